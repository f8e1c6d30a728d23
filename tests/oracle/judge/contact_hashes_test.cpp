// Contacts are the same bits on every compiler and processor: their hashes are constants.
#include <ostream>

#include <gtest/gtest.h>

#include <volccd/oracle/cases/colliding_scenes.hpp>
#include <volccd/oracle/cases/instruction_sets.hpp>
#include <volccd/pipelines/detector.hpp>

namespace volccd {
namespace {

/// FNV-1a over the bits of all members of contacts and ends.
class Hash {
 public:
  void add(const void* data, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i)
      value_ = (value_ ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211u;
  }
  void add(std::uint64_t value) { add(&value, sizeof value); }
  void add(double value) { add(&value, sizeof value); }
  void add(const Vec3& p) { add(p.data(), 3 * sizeof(double)); }
  void add(const std::array<double, 4>& values) { add(values.data(), sizeof values); }

  void add(const StepResult& result) {
    for (const Contact& c : result.contacts) {
      add(static_cast<std::uint64_t>(c.kind));
      for (const Index v : c.vertices) add(std::uint64_t{v});
      add(c.toi);
      add(c.normal);
      add(c.weights);
      add(c.point);
      add(std::uint64_t{c.at_start});
      add(c.gap);
    }
    for (const ContactEnd& e : result.ends) {
      add(e.gap);
      add(e.weights);
      add(e.first);
      add(e.second);
    }
    for (const ElementPair& pair : result.initial_overlaps) add(std::uint64_t{pair.a} << 32 | pair.b);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037u;
};

struct Hashes {
  std::uint64_t linear = 0, quadratic = 0;
  std::size_t contacts = 0;  ///< of both

  friend bool operator==(const Hashes&, const Hashes&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Hashes& h) {
    return out << std::hex << "0x" << h.linear << ", 0x" << h.quadratic << ", " << std::dec << h.contacts;
  }
};

/// A curved motion with the same ends.
Motion curved(const Motion& motion) {
  std::vector<Vec3> x0, xm, x1;
  for (Index v = 0; v < motion.vertex_count(); ++v) {
    x0.push_back(motion.point(v, 0));
    x1.push_back(motion.point(v, 1));
    xm.push_back((x0.back() + x1.back()) * 0.5 + Vec3(0.05, 0, 0.1));
  }
  return Motion::quadratic(x0, xm, x1);
}

/// Of scenes of every element type.
Hashes hashes_of(const std::string& pipeline, double jitter, double separation) {
  const Registry registry = Registry::standard();
  Hash linear, quadratic;
  std::size_t contacts = 0;
  const Request request{.initial_overlaps = true, .ends = true};
  for (const std::uint64_t seed : {1, 2})
    for (const cases::Scene& scene : cases::small_scenes(seed, jitter)) {
      StepRunner runner(Pipeline(registry, registry.pipeline(pipeline)), {.separation = separation});
      linear.add(runner.run(scene.topology, scene.motion, request));
      contacts += runner.result().contacts.size();
      quadratic.add(runner.run(scene.topology, curved(scene.motion), request));
      contacts += runner.result().contacts.size();
    }
  return {linear.value(), quadratic.value(), contacts};
}

// A change of these numbers is a change of contacts, which needs a line in CHANGELOG.md. A difference between
// compilers, processors or instruction sets is a defect (docs/installing.md).
constexpr Hashes kTouching{0x574ed3ac034a96c0, 0x265e69cd5484a2b6, 1890};
constexpr Hashes kSeparated{0x83228a35a5de064, 0x3de6f575454534f2, 2328};

TEST(ContactHashes, AreTheSameOnEveryCompilerAndProcessor) {
  for (const char* const pipeline : {"VolCCD", "NavCCD", "HashCCD"}) {
    SCOPED_TRACE(pipeline);
    EXPECT_EQ(hashes_of(pipeline, 0.1, 0), kTouching);
    EXPECT_EQ(hashes_of(pipeline, 0.3, 0.01), kSeparated);
  }
}

TEST(ContactHashes, AreTheSameOnEveryInstructionSet) {
  cases::InstructionSets().with_each([](const char* name) {
    SCOPED_TRACE(name);
    EXPECT_EQ(hashes_of("VolCCD+", 0.1, 0), kTouching);
    EXPECT_EQ(hashes_of("VolCCD+", 0.3, 0.01), kSeparated);
  });
}

}  // namespace
}  // namespace volccd
