#include <volccd/simulation/contact/contact_detection.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/query/shell_neighbours.hpp>

namespace volccd::simulation {
namespace {

constexpr std::size_t kChunk = TestBlock::kCapacity, kVertexGrain = 4096;
/// How early a contact may be reported, as a fraction of the step.
constexpr double kTimeTolerance = 1e-3;
/// Greatest number of intervals of the step in a search. Features that rest at the separation can need any number of
/// them; the search then ends, and they count as touching.
constexpr int kMaxIntervals = 40;
/// Reports every pair that the filters keep; contacts() decides later which of them touch.
class TakeAll final : public NarrowPhase {
 public:
  int max_control_points() const override { return 3; }
  bool handles_separation() const override { return true; }
  void run(const Step&, StageState&, unsigned, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters&) const override {
    for (std::size_t i = 0; i < block.size(); ++i)
      contacts.push_back({block.kind(), block.vertices(i), 0, Vec3::Zero(), {0, 0, 0, 0}, Vec3::Zero(), false});
  }
};

Pipeline make_pipeline(const std::string& name) {
  Registry registry = Registry::standard();
  registry.add<NarrowPhase>(
      {"take-all",
       "reports every pair that the filters keep",
       Guarantee::conservative,
       {},
       [](const OptionValues&) -> std::unique_ptr<NarrowPhase> { return std::make_unique<TakeAll>(); }});
  PipelineSpec spec = registry.pipeline(name);
  spec.narrow_phase = {"take-all"};
  // All pairs that filters keep are stored and tested many times.
  if (spec.feature_filters.empty()) spec.feature_filters = {{"feature-kdop"}, {"coplanarity"}, {"feature-csat"}};
  return Pipeline(registry, spec);
}

ObjectFilter filter_of(const ContactDetection::Config& config) {
  ObjectFilter filter;
  for (const auto& [a, b] : config.excluded) filter.exclude(a, b);
  return filter;
}

bool has_shells(const Mesh& mesh) {
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && is_shell(mesh.type(o))) return true;
  return false;
}

bool same(const ElementSpec& spec, const Mesh& mesh, Index o) {
  const std::span<const Index> vertices = mesh.vertices(o);
  return spec.type == mesh.type(o) && std::equal(vertices.begin(), vertices.end(), spec.vertices.begin());
}

}  // namespace

ContactDetection::ContactDetection(const Topology& model, std::span<const double> thickness,
                                   std::span<const Vec3> reference, Config config, Executor& executor)
    : model_(model),
      thickness_(thickness.begin(), thickness.end()),
      reference_(reference.begin(), reference.end()),
      config_(std::move(config)),
      runner_(make_pipeline(config_.pipeline), {.executor = &executor, .filter = filter_of(config_)}),
      narrow_(Inclusion::Config{.time_tolerance = kTimeTolerance, .max_intervals = kMaxIntervals}) {
  if (has_shells(model.mesh())) {
    thickener_.emplace(model.mesh());
    solid_ = std::make_unique<Topology>(thickener_->solid_mesh(model.mesh()), executor);
    // Otherwise edits would not have the same slots in both meshes.
    if (solid_->mesh().element_slots() != model.mesh().element_slots())
      throw InputError("model", "mesh", "a mesh with shells has empty element slots");
  }
  surface_.emplace(collision_topology(), config_.features, copies());
}

ContactDetection::~ContactDetection() = default;

void ContactDetection::follow(const TopologyEdit& edit, std::span<const double> thickness,
                              std::span<const Vec3> reference, std::span<const Index> origins) {
  thickness_.assign(thickness.begin(), thickness.end());
  reference_.assign(reference.begin(), reference.end());
  candidates_.clear();
  vf_.clear();
  ee_.clear();
  placed0_.from.clear();
  placed1_.from.clear();
  if (thickener_) {
    const Mesh& mesh = model_.mesh();
    thickener_.emplace(mesh);
    TopologyEdit solids;
    solids.new_vertex_ids = solid_vertex_ids(edit.new_vertex_ids);
    solids.removed = edit.removed;
    for (const ElementSpec& added : edit.added)
      solids.added.push_back(thickener_->solid_element(mesh, mesh.find_element(added.id)));
    solid_->apply(solids);
    // The edit may have changed the orientation of sheets: their other prisms are replaced, each in its own slot.
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      if (!mesh.is_live(o) || !is_shell(mesh.type(o))) continue;
      ElementSpec spec = thickener_->solid_element(mesh, o);
      if (!same(spec, solid_->mesh(), o)) solid_->apply({.removed = {o}, .added = {std::move(spec)}});
    }
  }
  surface_->update(collision_topology(), origins);
}

const std::vector<Vec3>& ContactDetection::place(std::span<const Vec3> x, Placed& placed, Executor& executor) {
  if (!std::equal(x.begin(), x.end(), placed.from.begin(), placed.from.end())) {
    thickener_->positions(x, thickness_, placed.to, scratch_, executor);
    placed.from.assign(x.begin(), x.end());
  }
  return placed.to;
}

/// A substep begins at the end of the one before it, and is tested several times with different ends.
void ContactDetection::set_motion(std::span<const Vec3> x0, std::span<const Vec3> x1, Executor& executor) {
  if (!thickener_) return motion_.set_linear(x0, x1);
  if (std::equal(x0.begin(), x0.end(), placed1_.from.begin(), placed1_.from.end())) std::swap(placed0_, placed1_);
  motion_.set_linear(place(x0, placed0_, executor), place(x1, placed1_, executor));
}

void ContactDetection::query(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const Vec3> ahead) {
  set_motion(x0, ahead.empty() ? x1 : ahead, runner_.executor());
  queried_ = motion_;
  queried_end_ = ahead.empty() ? 1 : 0.5;
  find_middles();
  reach_ = std::clamp(spread(), config_.min_margin, config_.max_margin);
  runner_.set_separation(config_.separation + reach_);
  const StepResult& found = runner_.run(collision_topology(), motion_);
  candidates_.clear();
  for (const Contact& contact : found.contacts)
    if (!thickener_ || !share_shell_vertex(contact.kind, contact.vertices))
      candidates_.push_back({contact.kind, contact.vertices});
  find_slots();
}

/// Greatest difference between displacements of vertices: contacts should not change displacements by more.
double ContactDetection::spread() const {
  Eigen::AlignedBox3d box;
  for (Index v = 0; v < motion_.vertex_count(); ++v) box.extend(Vec3(motion_.point(v, 1) - motion_.point(v, 0)));
  return box.isEmpty() ? 0 : 2 * box.diagonal().norm();
}

void ContactDetection::find_slots() {
  const Features& features = collision_topology().features();
  vf_.clear();
  ee_.clear();
  for (const auto& [kind, v] : candidates_) {
    if (kind == FeatureKind::vf) {
      vf_.push_back({v[0], features.find_triangle(v[1], v[2], v[3])});
    } else {
      const Index a = features.find_edge(v[0], v[1]), b = features.find_edge(v[2], v[3]);
      ee_.push_back({std::min(a, b), std::max(a, b)});
    }
  }
}

bool ContactDetection::covers(std::span<const Vec3> x0, std::span<const Vec3> x1, Executor& executor) {
  set_motion(x0, x1, executor);
  if (queried_.vertex_count() != motion_.vertex_count()) return false;
  const double reach = reach_ * reach_ / 4;
  std::atomic<bool> covered = true;
  executor.parallel_for(motion_.vertex_count(), kVertexGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (auto v = static_cast<Index>(begin); v < end && covered; ++v)
      for (int at = 0; at < 2; ++at)
        if (!((motion_.point(v, at) - queried_.position(v, at * queried_end_)).squaredNorm() <= reach)) covered = false;
  });
  return covered;
}

void ContactDetection::contacts(std::span<const Vec3> x0, std::span<const Vec3> x1, double separation,
                                Executor& executor, std::vector<FoundContact>& found) {
  found.clear();
  if (candidates() == 0) return;
  set_motion(x0, x1, executor);
  test(vf_, ee_, separation, executor, found);
}

void ContactDetection::keep_touching(Executor& executor, std::vector<FoundContact>& found) {
  std::vector<FeaturePair> vf, ee;
  for (const FoundContact& c : found) {
    if (c.verdict != ContactVerdict::resist) continue;
    // The distance decreases at most by the remaining motion of a vertex of one feature relative to one of the other.
    const std::size_t first = c.kind == FeatureKind::vf ? 1 : 2;
    double max = 0;
    for (std::size_t i = 0; i < first; ++i)
      for (std::size_t j = first; j < 4; ++j)
        max = std::max(max, (motion_.point(c.features[i], 1) - motion_.point(c.features[i], 0) -
                             motion_.point(c.features[j], 1) + motion_.point(c.features[j], 0))
                                .norm());
    const double apart = c.at_start ? std::abs(c.gap0) : config_.separation;
    if ((1 - c.toi + 1e-3) * max >= apart * (1 - 1e-3)) (c.kind == FeatureKind::vf ? vf : ee).push_back(slots(c));
  }
  found.clear();
  if (!vf.empty() || !ee.empty()) test(vf, ee, 0, executor, found);
  std::erase_if(found, [](const FoundContact& c) { return c.verdict != ContactVerdict::resist || c.at_start; });
}

FeaturePair ContactDetection::slots(const FoundContact& c) const {
  const Features& features = collision_topology().features();
  const auto& v = c.features;
  if (c.kind == FeatureKind::vf) return {v[0], features.find_triangle(v[1], v[2], v[3])};
  const Index a = features.find_edge(v[0], v[1]), b = features.find_edge(v[2], v[3]);
  return {std::min(a, b), std::max(a, b)};
}

void ContactDetection::test(const std::vector<FeaturePair>& vf, const std::vector<FeaturePair>& ee, double separation,
                            Executor& executor, std::vector<FoundContact>& found) {
  const Step step{collision_topology(), motion_, runner_.filter(), separation};
  const ContactJudge judge(
      {collision_topology(), motion_, *surface_, reference_, middles_, copies(), config_.adjacent, config_.separation});
  const std::size_t vf_chunks = (vf.size() + kChunk - 1) / kChunk, ee_chunks = (ee.size() + kChunk - 1) / kChunk;
  if (chunks_.size() < vf_chunks + ee_chunks) chunks_.resize(vf_chunks + ee_chunks);
  while (blocks_.size() < executor.workers()) blocks_.push_back(std::make_unique<TestBlock>());
  executor.parallel_for(vf_chunks + ee_chunks, 1, [&](std::size_t begin, std::size_t end, unsigned worker) {
    NarrowCounters counters;
    std::vector<Contact> contacts;
    TestBlock& block = *blocks_[worker];
    for (std::size_t c = begin; c < end; ++c) {
      const bool is_vf = c < vf_chunks;
      const std::vector<FeaturePair>& pairs = is_vf ? vf : ee;
      const std::size_t first = (is_vf ? c : c - vf_chunks) * kChunk;
      contacts.clear();
      const FeatureKind kind = is_vf ? FeatureKind::vf : FeatureKind::ee;
      block.gather(step, kind, std::span(pairs).subspan(first, std::min(kChunk, pairs.size() - first)));
      filter(step, block);
      StageState none;
      if (!block.empty()) narrow_.run(step, none, worker, block, contacts, counters);
      chunks_[c].clear();
      for (const Contact& contact : contacts) chunks_[c].push_back(judge.describe(contact));
    }
  });
  for (std::size_t c = 0; c < vf_chunks + ee_chunks; ++c)
    found.insert(found.end(), chunks_[c].begin(), chunks_[c].end());
}

/// Drops tests before the narrow phase: most pairs of a query are further apart than the separation in a substep.
void ContactDetection::filter(const Step& step, TestBlock& block) const {
  std::array<std::uint8_t, kChunk> keep;
  keep.fill(1);
  const auto flags = std::span(keep).first(block.padded_size());
  StageState none;
  kdop_filter_.run(step, none, 0, block, flags);
  csat_filter_.run(step, none, 0, block, flags);
  block.compact(flags);
}

void ContactDetection::find_middles() {
  const Mesh& mesh = collision_topology().mesh();
  std::vector<double> count;
  middles_.clear();
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    const auto object = static_cast<std::size_t>(mesh.object(o));
    if (object >= count.size()) {
      count.resize(object + 1, 0);
      middles_.resize(object + 1, Vec3::Zero());
    }
    for (Index v : mesh.vertices(o)) middles_[object] += motion_.point(v, 0);
    count[object] += static_cast<double>(mesh.vertices(o).size());
  }
  for (std::size_t i = 0; i < count.size(); ++i)
    if (count[i] > 0) middles_[i] /= count[i];
}

void ContactDetection::archive(Archive& archive) {
  static_assert(std::is_trivially_copyable_v<Candidate>);
  archive(candidates_);
  archive(middles_);
  if (!archive.reading()) return;
  for (const Candidate& candidate : candidates_)
    for (Index v : candidate.vertices)
      if (v >= collision_topology().mesh().vertex_count()) throw InputError("checkpoint", "contacts", "damaged");
  find_slots();
}

}  // namespace volccd::simulation
