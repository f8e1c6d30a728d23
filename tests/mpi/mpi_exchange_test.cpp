// The exchange of processes of MPI. With "fail R", rank R throws while the others wait; with "refuse R", it finds an
// error.
#include <volccd/distributed/mpi/mpi_program.hpp>

#include <stdexcept>
#include <string_view>

#include <gtest/gtest.h>

#include <volccd/distributed/agreement.hpp>
#include <volccd/distributed/detector.hpp>

#include "distributed/exchange_checks.hpp"

namespace volccd::distributed {
namespace {

MpiExchange* ranks = nullptr;

TEST(MpiExchange, ReduceGatherAndSend) {
  for (int i = 0; i < 3; ++i) test::check_exchange(*ranks);
}

TEST(MpiExchange, LongMessages) {
  const int next = (ranks->rank() + 1) % ranks->size(), last = (ranks->rank() + ranks->size() - 1) % ranks->size();
  const auto graph = ranks->connect({next});
  std::vector<Bytes> messages(1, Bytes(10'000'000, static_cast<std::byte>(ranks->rank())));
  const auto received = graph->exchange(std::move(messages));
  ASSERT_EQ(received.size(), 1u);
  EXPECT_EQ(received[0], Bytes(10'000'000, static_cast<std::byte>(last)));
}

/// Between the caller's messages with the same tags.
TEST(MpiExchange, HasItsOwnMessages) {
  MPI_Request request;
  int sent = 7, received = 0;
  MPI_Isend(&sent, 1, MPI_INT, (ranks->rank() + 1) % ranks->size(), 0, MPI_COMM_WORLD, &request);
  test::check_exchange(*ranks);
  MPI_Recv(&received, 1, MPI_INT, MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  EXPECT_EQ(received, 7);
}

/// Two tetrahedra, of which one falls onto the other; the last rank gives both.
TEST(MpiDetector, MoreRanksThanElements) {
  Detector detector(*ranks, Registry::standard(), Registry::standard().pipeline("VolCCD+"));
  const bool mine = ranks->rank() == ranks->size() - 1;
  Elements elements;
  std::vector<std::int64_t> ids;
  std::vector<Vec3> x0, x1;
  if (mine) {
    elements.add(ElementType::tetrahedron, std::vector<std::int64_t>{0, 1, 2, 3}, 0, 0);
    elements.add(ElementType::tetrahedron, std::vector<std::int64_t>{4, 5, 6, 7}, 1, 1);
    ids = {0, 1, 2, 3, 4, 5, 6, 7};
    x1 = x0 = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, -1, 2}, {2, -1, 2}, {-1, 2, 2}, {0, 0, 3}};
    for (std::size_t v = 4; v < 8; ++v) x1[v].z() -= 2;
  }
  for (int step = 0; step < 3; ++step) {
    detector.set_mesh(elements, ids);
    std::uint64_t contacts = detector.step(x0, x1).contacts.size();
    ranks->allreduce({&contacts, 1}, Reduction::sum);
    EXPECT_GT(contacts, 0u);
    EXPECT_EQ(detector.to_owners().size(), mine ? contacts : 0u);
  }
}

int run(MpiExchange& exchange, int argc, char** argv) {
  ranks = &exchange;
  if (argc == 3) {
    const bool mine = exchange.rank() == std::stoi(argv[2]);
    const auto work = [&] {
      if (mine) throw std::runtime_error("no more paper");
    };
    if (std::string_view(argv[1]) == "refuse") run_on_all(exchange, "printing", work);
    work();
    exchange.allgather({});
    return 0;
  }
  if (exchange.rank() != 0) {
    auto& listeners = testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
  }
  std::uint64_t failed = RUN_ALL_TESTS() == 0 ? 0 : 1;
  exchange.allreduce({&failed, 1}, Reduction::max);
  return static_cast<int>(failed);
}

}  // namespace
}  // namespace volccd::distributed

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return volccd::distributed::run_mpi_program("test_mpi", argc, argv, [&](volccd::distributed::MpiExchange& exchange) {
    return volccd::distributed::run(exchange, argc, argv);
  });
}
