#include <volccd/distributed/in_process_exchange.hpp>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include <volccd/distributed/agreement.hpp>

namespace volccd::distributed {

namespace {

/// Ends a rank after an error of another one.
struct Stopped {};

}  // namespace

/// Whose turn it is, and what the ranks have deposited. A rank that goes on after an operation may deposit for the next
/// one before others have read, but not for the one after that: hence two sets of deposits.
class InProcessRanks::Hub {
 public:
  /// What a rank brings to an operation.
  struct Deposit {
    std::vector<int> destinations;
    std::vector<Bytes> messages;
    std::vector<std::uint64_t> values;
  };

  explicit Hub(int ranks);

  int size() const { return static_cast<int>(places_.size()); }
  Exchange& exchange(int rank) { return *places_[static_cast<std::size_t>(rank)].exchange; }

  void begin_run();
  void serve(int rank, FunctionRef<void(Exchange&)> body);
  void stop(int rank, std::exception_ptr error);
  void throw_error();

  /// Deposits, waits for all ranks, and returns the deposits of all for this operation.
  std::vector<Deposit>& meet(int rank, const char* operation, Deposit deposit);

 private:
  enum class State { computing, waiting, ended };

  struct Place {
    std::unique_ptr<Exchange> exchange;
    std::unique_ptr<std::condition_variable> wake = std::make_unique<std::condition_variable>();
    State state = State::computing;
    const char* operation = "start";  ///< the last one
    unsigned parity = 0;
  };

  void wait_for_turn(int rank, std::unique_lock<std::mutex>& lock);
  void pass_turn();
  std::string disagreement() const;

  std::mutex mutex_;
  std::vector<Place> places_;
  std::vector<Deposit> deposits_[2];
  int turn_ = 0, failed_ = -1;
  std::exception_ptr error_;
};

class InProcessRanks::Graph final : public Neighbourhood {
 public:
  Graph(Hub& hub, int rank, std::vector<int> destinations, std::vector<int> sources)
      : Neighbourhood(std::move(destinations), std::move(sources)), hub_(hub), rank_(rank) {}

  std::vector<Bytes> exchange(std::vector<Bytes> messages) override {
    const auto to = destinations();
    std::vector<Hub::Deposit>& all = hub_.meet(rank_, "exchange", {{to.begin(), to.end()}, std::move(messages), {}});
    std::vector<Bytes> received;
    for (const int source : sources()) {
      Hub::Deposit& deposit = all[static_cast<std::size_t>(source)];
      const auto at = std::ranges::lower_bound(deposit.destinations, rank_) - deposit.destinations.begin();
      received.push_back(std::move(deposit.messages[static_cast<std::size_t>(at)]));
    }
    return received;
  }

 private:
  Hub& hub_;
  int rank_;
};

class InProcessRanks::Rank final : public Exchange {
 public:
  Rank(Hub& hub, int rank) : hub_(hub), rank_(rank) {}

  int rank() const override { return rank_; }
  int size() const override { return hub_.size(); }

  std::unique_ptr<Neighbourhood> connect(std::vector<int> destinations) override {
    const std::vector<Hub::Deposit>& all = hub_.meet(rank_, "connect", {destinations, {}, {}});
    std::vector<int> sources;
    for (int r = 0; r < size(); ++r)
      if (std::ranges::binary_search(all[static_cast<std::size_t>(r)].destinations, rank_)) sources.push_back(r);
    return std::make_unique<Graph>(hub_, rank_, std::move(destinations), std::move(sources));
  }

  std::vector<Bytes> allgather(Bytes bytes) override {
    Hub::Deposit mine;
    mine.messages.push_back(std::move(bytes));
    std::vector<Bytes> all;
    for (const Hub::Deposit& deposit : hub_.meet(rank_, "allgather", std::move(mine)))
      all.push_back(deposit.messages[0]);
    return all;
  }

  void allreduce(std::span<std::uint64_t> values, Reduction reduction) override {
    const std::vector<Hub::Deposit>& all = hub_.meet(rank_, "allreduce", {{}, {}, {values.begin(), values.end()}});
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = all[0].values[i];
      for (std::size_t r = 1; r < all.size(); ++r) {
        const std::uint64_t value = all[r].values[i];
        values[i] = reduction == Reduction::sum   ? values[i] + value
                    : reduction == Reduction::min ? std::min(values[i], value)
                                                  : std::max(values[i], value);
      }
    }
  }

 private:
  Hub& hub_;
  int rank_;
};

InProcessRanks::Hub::Hub(int ranks) : places_(static_cast<std::size_t>(ranks)) {
  for (int r = 0; r < ranks; ++r) places_[static_cast<std::size_t>(r)].exchange = std::make_unique<Rank>(*this, r);
}

void InProcessRanks::Hub::begin_run() {
  for (Place& place : places_) place.state = State::computing, place.operation = "start", place.parity = 0;
  for (auto& deposits : deposits_) deposits.assign(places_.size(), {});
  turn_ = 0;
  failed_ = -1;
  error_ = nullptr;
}

void InProcessRanks::Hub::serve(int rank, FunctionRef<void(Exchange&)> body) {
  try {
    {
      std::unique_lock lock(mutex_);
      wait_for_turn(rank, lock);
    }
    body(exchange(rank));
    const std::lock_guard lock(mutex_);
    places_[static_cast<std::size_t>(rank)].state = State::ended;
    pass_turn();
  } catch (const Stopped&) {
  } catch (...) {
    stop(rank, std::current_exception());
  }
}

void InProcessRanks::Hub::stop(int rank, std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  if (!error_) error_ = std::move(error), failed_ = rank;
  for (const Place& place : places_) place.wake->notify_one();
}

void InProcessRanks::Hub::throw_error() {
  if (!error_) return;
  const char* const operation = failed_ >= 0 ? places_[static_cast<std::size_t>(failed_)].operation : "start";
  try {
    std::rethrow_exception(std::exchange(error_, nullptr));
  } catch (const RankError&) {
    throw;
  } catch (const std::exception& error) {
    if (failed_ < 0) throw;
    std::throw_with_nested(RankError(failed_, size(), fmt::format("after {}", operation), problem_of(error)));
  }
}

void InProcessRanks::Hub::wait_for_turn(int rank, std::unique_lock<std::mutex>& lock) {
  places_[static_cast<std::size_t>(rank)].wake->wait(lock, [&] { return error_ || turn_ == rank; });
  if (error_) throw Stopped();
}

std::vector<InProcessRanks::Hub::Deposit>& InProcessRanks::Hub::meet(int rank, const char* operation, Deposit deposit) {
  std::unique_lock lock(mutex_);
  if (error_) throw Stopped();
  Place& place = places_[static_cast<std::size_t>(rank)];
  std::vector<Deposit>& deposits = deposits_[place.parity];
  place.parity ^= 1u;
  place.operation = operation;
  place.state = State::waiting;
  deposits[static_cast<std::size_t>(rank)] = std::move(deposit);
  pass_turn();
  wait_for_turn(rank, lock);
  return deposits;
}

/// To the next rank that computes or, if all wait in the same operation, to the first one.
void InProcessRanks::Hub::pass_turn() {
  auto next = std::ranges::find(places_, State::computing, &Place::state);
  if (next == places_.end()) {
    if (std::ranges::all_of(places_, [](const Place& place) { return place.state == State::ended; })) return;
    if (const std::string problem = disagreement(); !problem.empty()) {
      error_ = std::make_exception_ptr(RankError(problem));
      for (const Place& place : places_) place.wake->notify_one();
      return;
    }
    for (Place& place : places_) place.state = State::computing;
    next = places_.begin();
  }
  turn_ = static_cast<int>(next - places_.begin());
  next->wake->notify_one();
}

/// Why the ranks, which all wait or have ended, cannot go on.
std::string InProcessRanks::Hub::disagreement() const {
  const auto waiting = std::ranges::find(places_, State::waiting, &Place::state);
  for (const Place& place : places_) {
    const bool ended = place.state == State::ended;
    if (!ended && std::string_view(place.operation) == waiting->operation) continue;
    return fmt::format("rank {} {}, while rank {} waits in {}", &place - places_.data(),
                       ended ? std::string("has ended") : fmt::format("waits in {}", place.operation),
                       waiting - places_.begin(), waiting->operation);
  }
  return {};
}

InProcessRanks::InProcessRanks(int ranks) {
  if (ranks < 1) throw ConfigError(fmt::format("ranks: {}, but there must be one at least", ranks));
  hub_ = std::make_unique<Hub>(ranks);
}

InProcessRanks::~InProcessRanks() = default;
InProcessRanks::InProcessRanks(InProcessRanks&&) noexcept = default;
InProcessRanks& InProcessRanks::operator=(InProcessRanks&&) noexcept = default;

int InProcessRanks::size() const { return hub_->size(); }

void InProcessRanks::run(FunctionRef<void(Exchange&)> body) {
  Hub& hub = *hub_;
  hub.begin_run();
  {
    std::vector<std::jthread> threads;
    try {
      for (int r = 1; r < hub.size(); ++r) threads.emplace_back([&hub, &body, r] { hub.serve(r, body); });
    } catch (const std::system_error& error) {
      hub.stop(-1, std::make_exception_ptr(
                       ConfigError(fmt::format("ranks: the system refused thread {} of {} ({})", threads.size() + 2,
                                               hub.size(), error.code().message()))));
    }
    hub.serve(0, body);
  }
  hub.throw_error();
}

}  // namespace volccd::distributed
