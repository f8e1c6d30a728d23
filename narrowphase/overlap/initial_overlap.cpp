#include <volccd/narrowphase/overlap/initial_overlap.hpp>

#include <volccd/narrowphase/overlap/detail/hull_overlap.hpp>

namespace volccd {

struct InitialOverlapTest::Data {
  detail::HullPoints a, b;
  std::uint64_t close_calls = 0;

  void gather(const Step& step, Index o, detail::HullPoints& out) const {
    out.points.clear();
    for (const Index v : step.mesh().vertices(o)) out.points.push_back(step.motion.point(v, 0));
    out.measure();
  }

  /// Bounding boxes are tested first: fl(low - high) > separation implies the exact inequality, because rounding is
  /// monotone.
  bool boxes_apart(double separation) const {
    for (int k = 0; k < 3; ++k)
      if (b.low[k] - a.high[k] > separation || a.low[k] - b.high[k] > separation) return true;
    return false;
  }

  /// Pre: the rows of a refer to its first point.
  bool decide(double separation) {
    b.refer_to(a.points.front());
    detail::HullStart start;
    const detail::HullVerdict verdict = hulls_in_doubles(a, b, separation, start);
    if (verdict != detail::HullVerdict::close_call) return verdict == detail::HullVerdict::overlap;
    ++close_calls;
    return hulls_in_integers(a.points, b.points, separation, start);
  }
};

InitialOverlapTest::InitialOverlapTest() : data_(std::make_unique<Data>()) {}
InitialOverlapTest::~InitialOverlapTest() = default;
InitialOverlapTest::InitialOverlapTest(InitialOverlapTest&&) noexcept = default;
InitialOverlapTest& InitialOverlapTest::operator=(InitialOverlapTest&&) noexcept = default;

void InitialOverlapTest::find(const Step& step, std::span<const ElementPair> pairs, std::vector<ElementPair>& out) {
  Data& data = *data_;
  Index gathered = kNone;
  for (const ElementPair pair : pairs) {
    if (pair.a != gathered) {
      data.gather(step, pair.a, data.a);
      data.a.refer_to(data.a.points.front());
      gathered = pair.a;
    }
    data.gather(step, pair.b, data.b);
    if (!data.boxes_apart(step.separation) && data.decide(step.separation)) out.push_back(pair);
  }
}

bool InitialOverlapTest::overlap(std::span<const Vec3> a, std::span<const Vec3> b, double separation) {
  if (a.empty() || b.empty()) return false;
  Data& data = *data_;
  data.a.points.assign(a.begin(), a.end());
  data.b.points.assign(b.begin(), b.end());
  data.a.measure();
  data.b.measure();
  if (data.boxes_apart(separation)) return false;
  data.a.refer_to(a.front());
  return data.decide(separation);
}

std::uint64_t InitialOverlapTest::close_calls() const { return data_->close_calls; }

std::size_t InitialOverlapTest::bytes() const {
  std::size_t doubles = 0;
  for (const detail::HullPoints* points : {&data_->a, &data_->b})
    doubles += 3 * points->points.capacity() + 3 * points->rows[0].capacity();
  return doubles * sizeof(double);
}

}  // namespace volccd
