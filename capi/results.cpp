#include <volccd/capi/results.hpp>

#include <algorithm>

namespace volccd::capi {

namespace {

template <std::size_t N>
void copy(const std::array<double, N>& from, double (&to)[N]) {
  std::copy(from.begin(), from.end(), to);
}
void copy(const Vec3& from, double (&to)[3]) { std::copy_n(from.data(), 3, to); }

volccd_contact_end end_of(const ContactEnd& end) {
  volccd_contact_end result{};
  result.gap = end.gap;
  copy(end.weights, result.weights);
  copy(end.first, result.first);
  copy(end.second, result.second);
  return result;
}

void fill_contacts(std::vector<volccd_contact>& out, const std::vector<Contact>& contacts, const Mesh& mesh) {
  out.clear();
  out.reserve(contacts.size());
  for (const Contact& contact : contacts) out.push_back(contact_of(contact, mesh));
}

void fill_stage_statistics(Results& out, const StageStatistics& stage) {
  const auto add = [&](const std::string& what, double value) {
    out.names.push_back(stage.name + "." + what);
    out.statistics.push_back({out.names.back().c_str(), value});
  };
  add("in", static_cast<double>(stage.in));
  add("out", static_cast<double>(stage.out));
  add("prepare_seconds", stage.prepare_seconds);
  add("seconds", stage.seconds);
  for (const StageCounter& counter : stage.counters) add(std::string(counter.name), counter.value);
}

void fill_statistics(Results& out, const Statistics& s) {
  out.names.clear();
  out.statistics.clear();
  visit_values(s, [&](const char* name, auto value) { out.statistics.push_back({name, static_cast<double>(value)}); });
  for (const StageStatistics& stage : s.stages) fill_stage_statistics(out, stage);
}

}  // namespace

volccd_contact contact_of(const Contact& contact, const Mesh& mesh) {
  volccd_contact result{};
  result.kind = contact.kind == FeatureKind::vf ? VOLCCD_VF : VOLCCD_EE;
  result.at_start = contact.at_start ? 1 : 0;
  std::copy(contact.vertices.begin(), contact.vertices.end(), result.vertices);
  for (std::size_t side = 0; side < 2; ++side) {
    result.elements[side] = mesh.element_id(contact.elements[side]);
    result.objects[side] = mesh.object(contact.elements[side]);
  }
  result.time = contact.toi;
  copy(contact.normal, result.normal);
  copy(contact.point, result.point);
  copy(contact.weights, result.weights);
  result.gap = contact.gap;
  return result;
}

void fill(Results& out, const StepResult& result, const Mesh& mesh) {
  fill_contacts(out.contacts, result.contacts, mesh);
  out.ends.clear();
  out.ends.reserve(result.ends.size());
  for (const ContactEnd& end : result.ends) out.ends.push_back(end_of(end));
  out.initial_overlaps.clear();
  for (const ElementPair& pair : result.initial_overlaps)
    for (const Index o : {pair.a, pair.b}) out.initial_overlaps.push_back(mesh.element_id(o));
  fill_statistics(out, result.statistics);
}

void clear(Results& out) noexcept {
  out.contacts.clear();
  out.ends.clear();
  out.initial_overlaps.clear();
  out.statistics.clear();
}

}  // namespace volccd::capi
