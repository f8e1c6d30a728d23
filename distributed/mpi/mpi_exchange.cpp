#include <volccd/distributed/mpi/mpi_exchange.hpp>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
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

/// A communicator with the graph of a neighbourhood.
class Graph final : public Neighbourhood {
 public:
  /// `order[i]`: position of sources()[i] among the neighbours of the communicator.
  Graph(MPI_Comm communicator, std::vector<int> destinations, std::vector<int> sources, std::vector<int> order)
      : Neighbourhood(std::move(destinations), std::move(sources)),
        communicator_(communicator),
        order_(std::move(order)) {}
  ~Graph() override { MPI_Comm_free(&communicator_); }
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;

  std::vector<Bytes> exchange(std::vector<Bytes> messages) override {
    std::vector<std::uint64_t> sent, sizes(sources().size() + 1);  // one more, so that the address is valid
    for (const Bytes& message : messages) sent.push_back(message.size());
    sent.push_back(0);
    check(MPI_Neighbor_alltoall(sent.data(), 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, communicator_),
          "MPI_Neighbor_alltoall");
    std::vector<Bytes> received(sources().size());
    for (std::size_t i = 0; i < received.size(); ++i) received[i].resize(sizes[i]);
    alltoall(messages, received);
    std::vector<Bytes> result;
    for (const int i : order_) result.push_back(std::move(received[static_cast<std::size_t>(i)]));
    return result;
  }

 private:
  /// Buffers of messages, by absolute addresses.
  struct Buffers {
    explicit Buffers(std::vector<Bytes>& messages) : types(messages.size() + 1, MPI_BYTE) {
      for (Bytes& message : messages) {
        counts.push_back(int_of(message.size(), "MPI_Neighbor_alltoallw"));
        check(MPI_Get_address(message.data(), &places.emplace_back()), "MPI_Get_address");
      }
      counts.push_back(0);
      places.push_back(0);
    }

    std::vector<int> counts;
    std::vector<MPI_Aint> places;
    std::vector<MPI_Datatype> types;
  };

  void alltoall(std::vector<Bytes>& messages, std::vector<Bytes>& received) {
    const Buffers to(messages), from(received);
    check(MPI_Neighbor_alltoallw(MPI_BOTTOM, to.counts.data(), to.places.data(), to.types.data(), MPI_BOTTOM,
                                 from.counts.data(), from.places.data(), from.types.data(), communicator_),
          "MPI_Neighbor_alltoallw");
  }

  MPI_Comm communicator_;
  std::vector<int> order_;
};

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

std::unique_ptr<Neighbourhood> MpiExchange::connect(std::vector<int> destinations) {
  const int degree = static_cast<int>(destinations.size());
  destinations.push_back(0);  // so that the address is valid
  MPI_Comm graph = MPI_COMM_NULL;
  check(MPI_Dist_graph_create(communicator_, 1, &rank_, &degree, destinations.data(), MPI_UNWEIGHTED, MPI_INFO_NULL, 0,
                              &graph),
        "MPI_Dist_graph_create");
  check(MPI_Comm_set_errhandler(graph, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  int in = 0, out = 0, weighted = 0;
  check(MPI_Dist_graph_neighbors_count(graph, &in, &out, &weighted), "MPI_Dist_graph_neighbors_count");
  std::vector<int> from(static_cast<std::size_t>(in) + 1), to(static_cast<std::size_t>(out) + 1);
  check(MPI_Dist_graph_neighbors(graph, in, from.data(), MPI_UNWEIGHTED, out, to.data(), MPI_UNWEIGHTED),
        "MPI_Dist_graph_neighbors");
  from.pop_back();
  to.pop_back();
  destinations.pop_back();
  if (to != destinations) throw Error("MPI_Dist_graph_create: the destinations are in another order than given");
  std::vector<int> order(from.size());
  std::iota(order.begin(), order.end(), 0);
  const auto source = [&](int i) { return from[static_cast<std::size_t>(i)]; };
  std::ranges::sort(order, {}, source);
  std::vector<int> sources;
  for (const int i : order) sources.push_back(source(i));
  return std::make_unique<Graph>(graph, std::move(destinations), std::move(sources), std::move(order));
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
