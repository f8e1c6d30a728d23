#include <volccd/experiments/tables/query_source.hpp>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include <fmt/format.h>

#include <volccd/broadphase/candidate_pairs.hpp>
#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/culling/assignment/dynamic_assignment.hpp>
#include <volccd/culling/o_set/o_set_source.hpp>
#include <volccd/io/sequence/ground_truth.hpp>
#include <volccd/io/sequence/query_file.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/oracle/cases/query_set.hpp>

namespace volccd {

namespace {

std::vector<KnownQueries> from_query_file(const std::string& file) {
  std::vector<KnownQueries> result;
  for (QueryGroup& read : read_query_file(file)) {
    const auto group = std::make_shared<const QueryGroup>(std::move(read));
    const auto set = std::make_shared<const QuerySet>(group->kind, 2, group->points);
    KnownQueries queries{group->scene, group->kind,     set->step(), set, {set->pairs().begin(), set->pairs().end()},
                         {},           group->collides, {},          {}};
    queries.place = [group](std::uint64_t i) { return group->file_names[group->file[i]]; };
    result.push_back(std::move(queries));
  }
  return result;
}

/// One step of a sequence.
struct StepOfFile {
  StepOfFile(const std::string& file, const QuerySourceConfig& config) : reader(file), stepper(reader, config.stepper) {
    if (stepper.step_count() == 0) throw InputError(file, "VTKHDF/Steps", "has only one frame, and therefore no step");
    stepper.go_to(config.step);
  }
  Step step() const { return {stepper.topology(), stepper.motion(), filter}; }

  SequenceReader reader;
  SequenceStepper stepper;
  ObjectFilter filter;
};

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;

  bool overlaps(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

Box swept_box(const Motion& motion, std::span<const Index> vertices) {
  Box box;
  for (const Index v : vertices)
    for (int c = 0; c < motion.control_points(); ++c) {
      box.low = box.low.cwiseMin(motion.point(v, c));
      box.high = box.high.cwiseMax(motion.point(v, c));
    }
  return box;
}

/// Pairs without a common vertex whose swept boxes overlap, each once. Dynamic assignment gives every pair that is
/// contained in some overlapping element pair; the others are in the O-Set.
class Candidates {
 public:
  Candidates(const Step& step, const std::function<void()>& check) : step_(step), check_(check) {
    step_.range = PairRange::nonadjacent;
    collect();
  }

  std::vector<FeaturePair> vf, ee;

 private:
  void collect() {
    KdopBvh::Config boxes_alone;
    boxes_alone.k = 6;  // more axes would drop pairs whose boxes overlap
    const KdopBvh broad(boxes_alone);
    const DynamicAssignment assignment;
    const OSetSource orphans{OSetSource::Config{}};
    SerialExecutor executor;
    const auto boxes = broad.make_state(), owners = assignment.make_state(), o_set = orphans.make_state();
    broad.prepare(step_, *boxes, executor);
    assignment.prepare(step_, *owners, executor);
    orphans.prepare(step_, *o_set, executor);
    PairBatch batch;
    visit_candidates(broad, step_, *boxes, executor, [&](std::span<const ElementPair> pairs, unsigned) {
      batch.assign(pairs);
      assignment.run(step_, *owners, 0, batch, work_.tests);
      append_tests();
    });
    for (std::size_t block = 0; block < orphans.blocks(*o_set); ++block) {
      orphans.run(step_, *o_set, 0, block, work_);
      append_tests();
    }
    std::sort(vf.begin(), vf.end());
    std::sort(ee.begin(), ee.end());
  }

  void append_tests() {
    if (check_) check_();
    keep(FeatureKind::vf, work_.tests.vf, vf);
    keep(FeatureKind::ee, work_.tests.ee, ee);
    work_.tests.clear();
  }

  void keep(FeatureKind kind, const std::vector<FeaturePair>& from, std::vector<FeaturePair>& to) const {
    const std::size_t split = kind == FeatureKind::vf ? 1 : 2;
    for (const FeaturePair pair : from) {
      const std::array<Index, 4> v = test_vertices(step_.features(), kind, pair);
      const Box first = swept_box(step_.motion, std::span(v).first(split));
      if (first.overlaps(swept_box(step_.motion, std::span(v).subspan(split)))) to.push_back(pair);
    }
  }

  Step step_;
  const std::function<void()>& check_;
  Work work_;
};

/// The features of a known answer; slots of the mesh.
FeaturePair pair_of(const StepOfFile& source, const KnownAnswer& answer, std::int64_t row) {
  const auto ids = source.stepper.topology().mesh().vertex_ids();
  std::array<Index, 4> v;
  for (std::size_t i = 0; i < 4; ++i)
    v[i] = static_cast<Index>(std::lower_bound(ids.begin(), ids.end(), answer.ids[i]) - ids.begin());
  const Features& features = source.stepper.topology().features();
  FeaturePair pair = answer.kind == FeatureKind::vf
                         ? FeaturePair{v[0], features.find_triangle(v[1], v[2], v[3])}
                         : FeaturePair{features.find_edge(v[0], v[1]), features.find_edge(v[2], v[3])};
  if (pair.a == kNone || pair.b == kNone)
    throw InputError(source.reader.file(),
                     answer.kind == FeatureKind::vf ? "GroundTruth/VertexFace/Pairs" : "GroundTruth/EdgeEdge/Pairs",
                     row, "a feature of the pair is not in the mesh of frame 1");
  if (answer.kind == FeatureKind::ee && pair.b < pair.a) std::swap(pair.a, pair.b);
  return pair;
}

void append_listed(const StepOfFile& source, const std::vector<KnownAnswer>& answers, KnownQueries& queries) {
  for (const KnownAnswer& answer : answers) {
    if (answer.kind != queries.kind) continue;
    queries.pairs.push_back(pair_of(source, answer, static_cast<std::int64_t>(queries.pairs.size())));
    queries.collides.push_back(answer.collides ? 1 : 0);
    queries.toi.push_back(answer.toi);
  }
}

/// Replaces the listed pairs by `pairs`, which contain all that collide; keeps the known answers. Other pairs do not
/// collide.
void replace_pairs(const std::vector<FeaturePair>& pairs, KnownQueries& queries, const std::string& file) {
  std::vector<std::uint8_t> collides(pairs.size(), 0);
  std::vector<double> toi(pairs.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const auto at = std::lower_bound(pairs.begin(), pairs.end(), queries.pairs[i]);
    if (at == pairs.end() || *at != queries.pairs[i]) {
      if (queries.collides[i] == 0) continue;
      throw InputError(file, "GroundTruth", "a pair collides in the ground truth, but its swept boxes do not overlap");
    }
    const auto k = static_cast<std::size_t>(at - pairs.begin());
    collides[k] = queries.collides[i];
    toi[k] = queries.toi[i];
  }
  queries.pairs = pairs;
  queries.collides = std::move(collides);
  queries.toi = std::move(toi);
}

std::vector<KnownQueries> from_sequence(const std::string& file, const QuerySourceConfig& config) {
  const auto source = std::make_shared<StepOfFile>(file, config);
  const bool linear = config.stepper.motion == MotionModel::linear, candidates = config.candidates;
  const auto answers = config.step == 0 && linear ? read_ground_truth(source->reader) : std::nullopt;
  if (!answers && !candidates)
    throw InputError(
        file, "GroundTruth",
        fmt::format("{} step {}: there are candidates only (--candidates)",
                    linear ? "is missing for" : "holds for linear motion, not for this motion of", config.step));
  std::optional<Candidates> found;
  if (candidates) found.emplace(source->step(), config.check);
  const std::string scene = fmt::format("{}, step {}", candidates ? "candidates" : "listed", config.step);
  std::vector<KnownQueries> result;
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    KnownQueries queries{scene, kind, source->step(), source, {}, {}, {}, {}, {}};
    if (answers) append_listed(*source, *answers, queries);
    if (candidates) {
      const std::vector<FeaturePair>& pairs = kind == FeatureKind::vf ? found->vf : found->ee;
      if (answers)
        replace_pairs(pairs, queries, file);
      else
        queries.pairs = pairs;
    }
    if (queries.pairs.empty()) continue;
    queries.place = [source, kind, pairs = queries.pairs](std::uint64_t i) {
      const std::array<Index, 4> v = test_vertices(source->stepper.topology().features(), kind, pairs[i]);
      const auto id = [&](std::size_t p) { return source->stepper.topology().mesh().vertex_id(v[p]); };
      return kind == FeatureKind::vf ? fmt::format("{} | {} {} {}", id(0), id(1), id(2), id(3))
                                     : fmt::format("{} {} | {} {}", id(0), id(1), id(2), id(3));
    };
    result.push_back(std::move(queries));
  }
  return result;
}

template <class T>
void select(std::vector<T>& values, const std::vector<std::uint64_t>& index) {
  if (values.empty()) return;
  for (std::size_t i = 0; i < index.size(); ++i) values[i] = values[index[i]];
  values.resize(index.size());
}

/// Numbers the queries; keeps at most `most` of them, in order.
void number_and_sample(KnownQueries& queries, std::size_t max) {
  queries.index.resize(queries.size());
  std::iota(queries.index.begin(), queries.index.end(), std::uint64_t{0});
  if (max == 0 || queries.size() <= max) return;
  Random(0x5eed).shuffle(queries.index);
  queries.index.resize(max);
  std::sort(queries.index.begin(), queries.index.end());
  select(queries.pairs, queries.index);
  select(queries.collides, queries.index);
  select(queries.toi, queries.index);
}

}  // namespace

std::vector<KnownQueries> load_queries(const std::string& file, const QuerySourceConfig& config) {
  const bool sequence = is_sequence_file(file);
  if (!sequence && config.candidates) throw ConfigError("--candidates: is for sequences, not for a query file");
  std::vector<KnownQueries> result = sequence ? from_sequence(file, config) : from_query_file(file);
  for (KnownQueries& queries : result) number_and_sample(queries, config.sample);
  return result;
}

}  // namespace volccd
