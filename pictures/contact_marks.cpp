#include <volccd/pictures/contact_marks.hpp>

#include <algorithm>
#include <iterator>

#include <volccd/core/error.hpp>
#include <volccd/core/sort_unique.hpp>
#include <volccd/io/contacts_csv.hpp>
#include <volccd/pipelines/step_runner.hpp>

namespace volccd {

std::vector<PictureContact> find_contacts(SequenceReader& reader, int step, ShellModel shells, unsigned threads) {
  SequenceStepper::Config config;
  config.shells = shells;
  SequenceStepper stepper(reader, config);
  stepper.go_to(step);
  const Registry registry = Registry::standard();
  StepRunner runner(Pipeline(registry, registry.pipeline("VolCCD+")),
                    {.threads = threads, .leave_out_shell_neighbours = shells == ShellModel::solid});
  const StepResult& result = runner.run(stepper.topology(), stepper.motion());
  std::vector<PictureContact> contacts;
  contacts.reserve(result.contacts.size());
  for (const Contact& contact : result.contacts) contacts.push_back({contact.kind, contact.vertices, contact.point});
  return contacts;
}

std::vector<PictureContact> contacts_from_csv(const std::string& file, int step, std::span<const std::int64_t> ids) {
  std::vector<PictureContact> contacts;
  std::int64_t line = 1;
  for (const ContactRow& row : read_contacts_csv(file)) {
    ++line;
    if (row.step != step) continue;
    PictureContact contact{row.kind, {}, row.has_geometry ? std::optional(row.point) : std::nullopt};
    for (int k = 0; k < 4; ++k) {
      const auto found = std::lower_bound(ids.begin(), ids.end(), row.ids[k]);
      if (found == ids.end() || *found != row.ids[k])
        throw InputError(file, "line", line, "names a vertex that the sequence does not have");
      contact.vertices[k] = static_cast<Index>(found - ids.begin());
    }
    contacts.push_back(contact);
  }
  return contacts;
}

void classify(std::vector<PictureContact>& contacts, const SequenceCells& cells, Index vertex_count) {
  std::vector<char> wanted(vertex_count);
  for (const PictureContact& contact : contacts)
    for (const Index v : contact.vertices) wanted[v] = 1;
  std::vector<std::pair<Index, std::int32_t>> parts;  // of vertices
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    for (const Index v : cells.vertices(cell))
      if (wanted[v]) parts.emplace_back(v, cells.objects[cell]);
  sort_unique(parts);

  std::vector<std::int32_t> first, second, scratch, both;
  const auto parts_of = [&](Index v, std::vector<std::int32_t>& out) {
    out.clear();
    for (auto at = std::lower_bound(parts.begin(), parts.end(), std::pair(v, INT32_MIN));
         at != parts.end() && at->first == v; ++at)
      out.push_back(at->second);
  };
  const auto common = [&](std::span<const Index> vertices, std::vector<std::int32_t>& out) {
    parts_of(vertices[0], out);
    for (const Index v : vertices.subspan(1)) {
      parts_of(v, scratch);
      both.clear();
      std::set_intersection(out.begin(), out.end(), scratch.begin(), scratch.end(), std::back_inserter(both));
      out.swap(both);
    }
  };
  for (PictureContact& contact : contacts) {
    const std::span<const Index> vertices(contact.vertices);
    const std::size_t split = contact.kind == FeatureKind::vf ? 1 : 2;
    common(vertices.first(split), first);
    common(vertices.subspan(split), second);
    both.clear();
    std::set_intersection(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(both));
    contact.inter = both.empty();
  }
}

Vec3 mark_place(const PictureContact& contact, std::span<const Vec3> points) {
  if (contact.point) return *contact.point;
  const Vec3& first = points[contact.vertices[0]];
  return contact.kind == FeatureKind::vf ? first : Vec3(0.5 * (first + points[contact.vertices[1]]));
}

}  // namespace volccd
