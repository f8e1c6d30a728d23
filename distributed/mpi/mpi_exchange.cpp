#include <volccd/distributed/mpi/mpi_exchange.hpp>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>

namespace volccd::distributed {

namespace {

void check(int code, const char* operation) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  if (MPI_Error_string(code, text, &length) != MPI_SUCCESS) length = 0;
  throw Error(fmt::format("{}: {}", operation, std::string(text, static_cast<std::size_t>(length))));
}

int int_of(std::uint64_t bytes, const char* operation) {
  if (bytes > static_cast<std::uint64_t>(std::numeric_limits<int>::max()))
    throw Error(fmt::format("{}: a message of {} bytes is longer than MPI sends; take more ranks", operation, bytes));
  return static_cast<int>(bytes);
}

/// Tags of messages: of neighbourhoods, and of connect(), alternately.
constexpr int kMessage = 0, kConnect = 1;

class Graph final : public Neighbourhood {
 public:
  Graph(MPI_Comm communicator, std::vector<int> destinations, std::vector<int> sources)
      : Neighbourhood(std::move(destinations), std::move(sources)), communicator_(communicator) {}

  /// Messages between two ranks do not overtake each other, and all ranks exchange in the same order, so that one tag
  /// serves all neighbourhoods.
  std::vector<Bytes> exchange(std::vector<Bytes> messages) override {
    std::vector<MPI_Request> sends(messages.size(), MPI_REQUEST_NULL);
    for (std::size_t i = 0; i < messages.size(); ++i)
      check(MPI_Isend(messages[i].data(), int_of(messages[i].size(), "MPI_Isend"), MPI_BYTE, destinations()[i],
                      kMessage, communicator_, &sends[i]),
            "MPI_Isend");
    std::vector<Bytes> received;
    for (const int source : sources()) received.push_back(receive(source));
    check(MPI_Waitall(static_cast<int>(sends.size()), sends.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
    return received;
  }

 private:
  Bytes receive(int source) {
    MPI_Message message = MPI_MESSAGE_NULL;
    MPI_Status status;
    check(MPI_Mprobe(source, kMessage, communicator_, &message, &status), "MPI_Mprobe");
    int size = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &size), "MPI_Get_count");
    Bytes bytes(static_cast<std::size_t>(size));
    check(MPI_Mrecv(bytes.data(), size, MPI_BYTE, &message, MPI_STATUS_IGNORE), "MPI_Mrecv");
    return bytes;
  }

  MPI_Comm communicator_;
};

/// Receives an empty message with this tag from any rank, if there is one, and appends the rank.
void receive_empty(MPI_Comm communicator, int tag, std::vector<int>& sources) {
  MPI_Message message = MPI_MESSAGE_NULL;
  MPI_Status status;
  int there = 0;
  check(MPI_Improbe(MPI_ANY_SOURCE, tag, communicator, &there, &message, &status), "MPI_Improbe");
  if (there == 0) return;
  check(MPI_Mrecv(nullptr, 0, MPI_BYTE, &message, MPI_STATUS_IGNORE), "MPI_Mrecv");
  sources.push_back(status.MPI_SOURCE);
}

}  // namespace

MpiExchange::MpiExchange(MPI_Comm communicator) {
  check(MPI_Comm_dup(communicator, &communicator_), "MPI_Comm_dup");
  check(MPI_Comm_set_errhandler(communicator_, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  check(MPI_Comm_rank(communicator_, &rank_), "MPI_Comm_rank");
  check(MPI_Comm_size(communicator_, &size_), "MPI_Comm_size");
}

MpiExchange::~MpiExchange() {
  if (communicator_ != MPI_COMM_NULL) MPI_Comm_free(&communicator_);
}

/// Sends an empty message to each destination. When all of them are received, which synchronous sends tell, the rank
/// enters the barrier; when all ranks have entered it, no message is on its way.
std::unique_ptr<Neighbourhood> MpiExchange::connect(std::vector<int> destinations) {
  const int tag = kConnect + connections_;
  connections_ ^= 1;
  std::vector<MPI_Request> sends(destinations.size(), MPI_REQUEST_NULL);
  for (std::size_t i = 0; i < destinations.size(); ++i)
    check(MPI_Issend(nullptr, 0, MPI_BYTE, destinations[i], tag, communicator_, &sends[i]), "MPI_Issend");
  std::vector<int> sources;
  MPI_Request barrier = MPI_REQUEST_NULL;
  for (bool entered = false, done = false; !done;) {
    receive_empty(communicator_, tag, sources);
    int complete = 0;
    if (entered) {
      check(MPI_Test(&barrier, &complete, MPI_STATUS_IGNORE), "MPI_Test");
      done = complete != 0;
      continue;
    }
    check(MPI_Testall(static_cast<int>(sends.size()), sends.data(), &complete, MPI_STATUSES_IGNORE), "MPI_Testall");
    if (complete == 0) continue;
    check(MPI_Ibarrier(communicator_, &barrier), "MPI_Ibarrier");
    entered = true;
  }
  std::ranges::sort(sources);
  return std::make_unique<Graph>(communicator_, std::move(destinations), std::move(sources));
}

std::vector<Bytes> MpiExchange::allgather(Bytes bytes) {
  const auto ranks = static_cast<std::size_t>(size_);
  const std::uint64_t mine = bytes.size();
  std::vector<std::uint64_t> sizes(ranks);
  check(MPI_Allgather(&mine, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, communicator_), "MPI_Allgather");
  std::vector<int> counts, begins;
  std::uint64_t sum = 0;
  for (const std::uint64_t size : sizes) {
    begins.push_back(int_of(sum, "MPI_Allgatherv"));
    counts.push_back(int_of(size, "MPI_Allgatherv"));
    sum += size;
  }
  Bytes all(static_cast<std::size_t>(int_of(sum, "MPI_Allgatherv")));
  check(MPI_Allgatherv(bytes.data(), counts[static_cast<std::size_t>(rank_)], MPI_BYTE, all.data(), counts.data(),
                       begins.data(), MPI_BYTE, communicator_),
        "MPI_Allgatherv");
  std::vector<Bytes> result;
  for (std::size_t r = 0; r < ranks; ++r)
    result.emplace_back(all.begin() + begins[r], all.begin() + begins[r] + counts[r]);
  return result;
}

void MpiExchange::allreduce(std::span<std::uint64_t> values, Reduction reduction) {
  const MPI_Op operation = reduction == Reduction::sum ? MPI_SUM : reduction == Reduction::min ? MPI_MIN : MPI_MAX;
  check(MPI_Allreduce(MPI_IN_PLACE, values.data(), int_of(values.size(), "MPI_Allreduce"), MPI_UINT64_T, operation,
                      communicator_),
        "MPI_Allreduce");
}

}  // namespace volccd::distributed
