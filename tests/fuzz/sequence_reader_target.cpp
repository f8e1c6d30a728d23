#include <fstream>
#include <iterator>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/ground_truth.hpp>
#include <volccd/io/sequence/stepper.hpp>

#include "hdf5_script.hpp"
#include "io/sequence/raw_hdf5.hpp"
#include "io/sequence/sequences.hpp"

namespace volccd::fuzz {

namespace {

/// All element types, parts, and ids with gaps; with and without velocity and thickness.
std::vector<Image> make_bases() {
  std::vector<Image> bases;
  const test::ScratchFolder folder;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const std::string name = folder / "s.vtkhdf";
    test::random_sequence(seed, 3).write(name);
    {
      test::RawFile raw(name);
      raw.group("GroundTruth");
      raw.group("GroundTruth/EdgeEdge");
      raw.put("GroundTruth/Edges", {2, 2}, H5T_STD_I32LE, std::vector<std::int64_t>{0, 1, 2, 3});
      raw.put("GroundTruth/EdgeEdge/Pairs", {1, 2}, H5T_STD_I32LE, std::vector<std::int64_t>{0, 1});
      raw.put("GroundTruth/EdgeEdge/Collides", {1}, H5T_STD_U8LE, std::vector<std::int64_t>{1});
      raw.put("GroundTruth/EdgeEdge/TimeOfImpact", {1}, H5T_IEEE_F64LE, std::vector<double>{0.5});
    }
    std::ifstream in(name, std::ios::binary);
    bases.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return bases;
}

void read_sequence(const std::string& name, std::uint8_t choice) {
  SequenceReader reader(name);
  try {
    reader.check_contents();
    read_ground_truth(reader);
  } catch (const InputError&) {  // steps before the damaged one can be read
  }
  SequenceStepper::Config config;
  config.edge_set = choice & 1 ? EdgeSet::polytope : EdgeSet::triangulated;
  config.shells = choice & 2 ? ShellModel::solid : ShellModel::surface;
  config.motion = choice & 4 ? MotionModel::quadratic : choice & 16 ? MotionModel::tentative : MotionModel::linear;
  SequenceStepper stepper(reader, config);
  for (int k = 0; k < std::min(stepper.step_count(), 4); ++k) {
    try {
      stepper.go_to(choice & 8 ? stepper.step_count() - 1 - k : k);
    } catch (const InputError&) {
      continue;
    }
    for (Index v = 0; v < stepper.motion().vertex_count(); ++v)
      for (int c = 0; c < stepper.motion().control_points(); ++c)
        if (!stepper.motion().point(v, c).allFinite()) promise_broken("a motion that is not finite");
  }
}

}  // namespace

void sequence_reader(Bytes bytes) {
  static const std::vector<Image> bases = make_bases();
  read_spoilt(bytes, bases, read_sequence);
}

}  // namespace volccd::fuzz
