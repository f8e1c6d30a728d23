#include "mesh_script.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <volccd/core/error.hpp>

namespace volccd::fuzz {

namespace {

using Faces = std::vector<std::vector<Index>>;

Vec3 on_lattice(const Vec3& p) {
  return p.unaryExpr([](double x) {
    return std::clamp(std::round(x), -MeshScript::kMaxCoordinate, MeshScript::kMaxCoordinate) + 0.0;
  });
}

/// The faces of an element in vertex slots, each in the outward order of a positive volume.
Faces faces_of(const ElementSpec& element) {
  Faces faces;
  if (element.type == ElementType::polytope) {
    visit_faces(std::span(element.faces),
                [&](std::span<const Index> face) { faces.emplace_back(face.begin(), face.end()); });
    return faces;
  }
  visit_faces(face_stream(element.type), [&](std::span<const std::uint8_t> face) {
    faces.emplace_back();
    for (const std::uint8_t i : face) faces.back().push_back(element.vertices[i]);
  });
  return faces;
}

std::vector<Index> stream_of(const Faces& faces) {
  std::vector<Index> stream;
  for (const std::vector<Index>& face : faces) {
    stream.push_back(static_cast<Index>(face.size()));
    stream.insert(stream.end(), face.begin(), face.end());
  }
  return stream;
}

bool has_vertex(const ElementSpec& element, Index v) {
  return std::find(element.vertices.begin(), element.vertices.end(), v) != element.vertices.end();
}

bool all_different(std::vector<Index> vertices) {
  std::sort(vertices.begin(), vertices.end());
  return std::adjacent_find(vertices.begin(), vertices.end()) == vertices.end();
}

/// Removes a pair of faces with the same vertices from the union of two lists of faces.
Faces merged(Faces faces, const Faces& others) {
  const auto sorted = [](std::vector<Index> face) {
    std::sort(face.begin(), face.end());
    return face;
  };
  for (const std::vector<Index>& other : others) {
    const auto twin = std::find_if(faces.begin(), faces.end(),
                                   [&](const std::vector<Index>& face) { return sorted(face) == sorted(other); });
    if (twin != faces.end())
      faces.erase(twin);
    else
      faces.push_back(other);
  }
  return faces;
}

}  // namespace

std::size_t MeshScript::Scene::element_count() const {
  return edit.added.size() + (topology ? topology->mesh().element_count() : 0) - edit.removed.size();
}

bool MeshScript::Scene::is_removed(Index slot) const {
  return std::find(edit.removed.begin(), edit.removed.end(), slot) != edit.removed.end();
}

/// The order is part of the format of the corpus: new operations go to the end, and replace a repeated entry.
const std::vector<MeshScript::Operation>& MeshScript::operations() {
  using S = MeshScript;
  static const std::vector<Operation> all = {
      &S::request_step, &S::add_vertex,       &S::add_fine_vertex, &S::add_element, &S::add_polytope, &S::cone_face,
      &S::extrude_face, &S::glue_tetrahedron, &S::add_block,       &S::cone_star,   &S::fan,          &S::add_strip,
      &S::add_copy,     &S::identify,         &S::reverse,         &S::shuffle,     &S::set_object,   &S::remove,
      &S::restore,      &S::set_point,        &S::move_point,      &S::move_range,  &S::jitter,       &S::mirror,
      &S::rest,         &S::set_scene,        &S::set_scale,       &S::set_filter,  &S::jitter,       &S::cone_face,
      &S::move_point,   &S::request_step};
  return all;
}

bool MeshScript::next_step() {
  if (motion_.vertex_count() > 0)  // the next step begins where this one ended
    for (Point& p : scene().points) p.start = p.middle = p.end;
  motion_ = Motion();
  const std::vector<Operation>& all = operations();
  while (steps_ < kMaxSteps && work_ < kMaxWork && !in_.empty()) {
    step_requested_ = false;
    begins_.push_back(bytes_.size() - in_.rest().size());
    (this->*all[in_.byte() % all.size()])();
    if (step_requested_) return finish_step();
  }
  if (steps_ == 0 || steps_ >= kStepsWithRandomMotions || work_ >= kMaxWork || !scene().topology) return false;
  set_random_motion();
  return finish_step();
}

bool MeshScript::finish_step() {
  if (!apply_edit() || topology().mesh().element_count() == 0) return false;
  set_motion();
  ++steps_;
  work_ += topology().mesh().element_count();
  return true;
}

void MeshScript::set_random_motion() {
  std::uint64_t seed = static_cast<std::uint64_t>(steps_);
  for (const std::uint8_t byte : bytes_) seed = hash_ids(seed, byte);
  Random random(seed);
  options_ = {};
  options_.quadratic = random.below(8) == 0;
  const std::uint64_t range = std::uint64_t{2} << random.below(6);
  const auto displaced = [&](const Vec3& p) {
    const auto next = [&] { return static_cast<double>(random.below(2 * range + 1)) - static_cast<double>(range); };
    const double x = next(), y = next(), z = next();
    return on_lattice(p + Vec3(x, y, z));
  };
  const bool from_rest = random.below(2) == 0;
  for (Point& p : scene().points) {
    if (from_rest) p.start = p.rest;
    p.middle = displaced(p.start);
    p.end = displaced(p.start);
  }
}

std::vector<Bytes> MeshScript::operations_read() const {
  std::vector<Bytes> result;
  for (std::size_t i = 0; i < begins_.size(); ++i) {
    const std::size_t end = i + 1 < begins_.size() ? begins_[i + 1] : bytes_.size() - in_.rest().size();
    result.push_back(bytes_.subspan(begins_[i], end - begins_[i]));
  }
  return result;
}

bool MeshScript::apply_edit() {
  Scene& s = scene();
  const Index known = s.topology ? s.topology->mesh().vertex_count() : 0;
  std::sort(s.edit.removed.begin(), s.edit.removed.end());
  for (Index v = known; v < s.points.size(); ++v) s.edit.new_vertex_ids.push_back(v);
  try {
    if (!s.topology) {
      Mesh mesh;
      mesh.add_vertices(s.edit.new_vertex_ids);
      for (const ElementSpec& e : s.edit.added) mesh.add_element(e);
      s.topology = std::make_unique<Topology>(std::move(mesh));
    } else if (!s.edit.empty()) {
      s.topology->apply(s.edit);
    }
  } catch (const InputError&) {
    return false;
  }
  s.edit = {};
  return true;
}

void MeshScript::set_motion() {
  const std::vector<Point>& points = scene().points;
  motion_ = Motion(static_cast<Index>(points.size()), options_.quadratic ? 3 : 2);
  for (Index v = 0; v < points.size(); ++v) {
    motion_.set(v, 0, points[v].start);
    if (options_.quadratic) motion_.set(v, 1, points[v].middle);
    motion_.set(v, motion_.degree(), points[v].end);
  }
}

Vec3 MeshScript::small_vector() {
  const double x = in_.small(), y = in_.small(), z = in_.small();
  return {x, y, z};
}

Vec3 MeshScript::lattice_point() { return on_lattice(scale_ * small_vector()); }

Vec3 MeshScript::fine_point() {
  const auto next = [&] { return static_cast<double>(static_cast<std::int16_t>(in_.bits(2))); };
  const double x = next(), y = next(), z = next();
  return on_lattice({x, y, z});
}

Index MeshScript::new_vertex(const Vec3& position) {
  const Vec3 p = on_lattice(position);
  scene().points.push_back({p, p, p, p});
  return static_cast<Index>(scene().points.size() - 1);
}

void MeshScript::push(ElementType type, std::vector<Index> vertices, std::vector<Index> faces) {
  Scene& s = scene();
  if (s.element_count() >= kMaxElements || !all_different(vertices)) return;
  s.edit.added.push_back({.type = type,
                          .vertices = std::move(vertices),
                          .faces = std::move(faces),
                          .object = s.object,
                          .id = s.next_id++});
}

void MeshScript::append(const Shape& shape, const Vec3& origin, double spacing) {
  Scene& s = scene();
  if (s.points.size() + shape.positions.size() > kMaxVertices) return;
  if (s.element_count() + shape.elements.size() > kMaxElements) return;
  const auto first = static_cast<Index>(s.points.size());
  for (const Vec3& p : shape.positions) new_vertex(origin + spacing * p);
  for (ElementSpec e : shape.elements) {
    e.renumber([&](Index v) { return first + v; });
    push(e.type, e.vertices, e.faces);
  }
}

ElementSpec MeshScript::some_element() {
  const Scene& s = scene();
  std::vector<Index> live;
  for (Index o = 0; s.topology && o < s.topology->mesh().element_slots(); ++o)
    if (s.topology->mesh().is_live(o) && !s.is_removed(o)) live.push_back(o);
  if (live.size() + s.edit.added.size() == 0) return {};
  const std::size_t i = in_.below(live.size() + s.edit.added.size());
  return i < live.size() ? s.topology->mesh().spec(live[i]) : s.edit.added[i - live.size()];
}

std::vector<Index> MeshScript::some_face() {
  const ElementSpec element = some_element();
  const std::uint8_t which = in_.byte();
  const Faces faces = faces_of(element);
  return faces.empty() ? std::vector<Index>() : faces[which % faces.size()];
}

void MeshScript::add_vertex() {
  const Vec3 p = lattice_point();
  if (scene().points.size() < kMaxVertices) new_vertex(p);
}

void MeshScript::add_fine_vertex() {
  const Vec3 p = fine_point();
  if (scene().points.size() < kMaxVertices) new_vertex(p);
}

void MeshScript::add_element() {
  constexpr std::array kTypes = {ElementType::tetrahedron, ElementType::triangle,   ElementType::pyramid,
                                 ElementType::wedge,       ElementType::hexahedron, ElementType::quad};
  const ElementType type = kTypes[in_.below(kTypes.size())];
  if (!has_vertices()) return;
  std::vector<Index> vertices(static_cast<std::size_t>(vertex_count(type)));
  for (Index& v : vertices) v = some_vertex();
  push(type, vertices);
}

/// The union of two elements that have a face in common, or a copy of one element, as a polytope.
void MeshScript::add_polytope() {
  const ElementSpec one = some_element(), other = some_element();
  if (one.type == ElementType::none || is_shell(one.type) || is_shell(other.type)) return;
  Faces faces = faces_of(one);
  const Faces all = merged(faces, faces_of(other));
  if (one.id != other.id && all.size() + 2 == faces.size() + faces_of(other).size()) faces = all;
  std::vector<Index> vertices;
  for (const std::vector<Index>& face : faces) vertices.insert(vertices.end(), face.begin(), face.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::erase_if(scene().edit.added, [&](const ElementSpec& e) { return e.id == one.id || e.id == other.id; });
  push(ElementType::polytope, vertices, stream_of(faces));
}

void MeshScript::cone_face() {
  std::vector<Index> face = some_face();
  const Vec3 by = lattice_point();
  const bool old = in_.byte() & 1;
  if (face.empty() || face.size() > 4 || scene().points.size() >= kMaxVertices) return;
  face.push_back(old ? some_vertex() : new_vertex(scene().points[face[0]].rest + by));
  push(face.size() == 4 ? ElementType::tetrahedron : ElementType::pyramid, face);
}

void MeshScript::extrude_face() {
  const std::vector<Index> face = some_face();
  const Vec3 by = lattice_point();
  if (face.empty() || face.size() > 4 || scene().points.size() + face.size() > kMaxVertices) return;
  std::vector<Index> vertices = face;
  // The first triangle of a wedge is clockwise as seen from the second one.
  if (face.size() == 3) std::swap(vertices[1], vertices[2]);
  for (std::size_t i = 0; i < face.size(); ++i) vertices.push_back(new_vertex(scene().points[vertices[i]].rest + by));
  push(face.size() == 3 ? ElementType::wedge : ElementType::hexahedron, vertices);
}

/// Cones a face over the reflection of its element's centroid.
void MeshScript::glue_tetrahedron() {
  const ElementSpec element = some_element();
  const std::uint8_t which = in_.byte();
  const Faces faces = faces_of(element);
  if (faces.empty() || scene().points.size() >= kMaxVertices) return;
  std::vector<Index> face = faces[which % faces.size()];
  if (face.size() > 4) return;
  const auto centroid = [&](const std::vector<Index>& vertices) {
    Vec3 sum = Vec3::Zero();
    for (const Index v : vertices) sum += scene().points[v].rest;
    return Vec3(sum / static_cast<double>(vertices.size()));
  };
  face.push_back(new_vertex(3 * centroid(face) - 2 * centroid(element.vertices)));
  push(face.size() == 4 ? ElementType::tetrahedron : ElementType::pyramid, face);
}

void MeshScript::add_block() {
  constexpr std::array kTypes = {ElementType::tetrahedron, ElementType::pyramid,  ElementType::hexahedron,
                                 ElementType::wedge,       ElementType::polytope, ElementType::triangle,
                                 ElementType::quad};
  const std::uint8_t type = in_.byte(), size = in_.byte();
  const Vec3 origin = lattice_point();
  const double spacing = 2.0 * in_.byte() + 2;
  const int nx = 1 + size % 4, ny = 1 + size / 4 % 4, nz = 1 + size / 16 % 4;
  if (type % 8 == 7)
    append(mixed_block(1, 1), origin, spacing);
  else
    append(block(kTypes[type % 8], nx, ny, nz), origin, spacing);
}

/// Tetrahedra between a vertex and given triangles, its link.
void MeshScript::cone_star() {
  const std::uint8_t count = in_.byte();
  if (!has_vertices()) return;
  const Index v = some_vertex();
  for (int i = 0; i < 1 + count % 32; ++i) {
    const Index a = some_vertex(), b = some_vertex(), c = some_vertex();
    push(ElementType::tetrahedron, {a, b, c, v});
  }
}

/// Tetrahedra around the edge between two vertices: v, pole, and consecutive vertices of a ring that may be closed.
void MeshScript::fan() {
  const std::uint8_t count = in_.byte();
  if (!has_vertices()) return;
  const Index v = some_vertex(), pole = some_vertex(), first = some_vertex();
  const bool closed = count & 128, reversed = count & 64;
  const Index n = 2 + count % 16;
  const auto ring = [&](Index i) { return static_cast<Index>((first + i) % scene().points.size()); };
  for (Index i = 0; i + (closed ? 0 : 1) < n; ++i) {
    const Index a = ring(i), b = ring((i + 1) % n);
    push(ElementType::tetrahedron, {v, reversed ? b : a, reversed ? a : b, pole});
  }
}

/// A strip of triangles or tetrahedra that begins at an old vertex; each element has one new vertex, the first one
/// more.
void MeshScript::add_strip() {
  const std::uint8_t what = in_.byte();
  if (!has_vertices()) return;
  const std::size_t corners = what & 1 ? 4 : 3;
  std::vector<Index> last = {some_vertex()};
  for (int i = 0; i < 1 + what / 2 % 8; ++i) {
    while (last.size() < corners) {
      if (scene().points.size() >= kMaxVertices) return;
      last.push_back(new_vertex(scene().points[last.back()].rest + lattice_point()));
    }
    push(corners == 3 ? ElementType::triangle : ElementType::tetrahedron, last);
    last.erase(last.begin());
  }
}

/// A copy of all elements that are not yet in the topology, displaced, in another object.
void MeshScript::add_copy() {
  const Vec3 by = lattice_point();
  Shape shape;
  for (const Point& p : scene().points) shape.positions.push_back(p.rest);
  shape.elements = scene().edit.added;
  ++scene().object;
  append(shape, by, 1);
}

/// Replaces a vertex by another one in all elements that are not yet in the topology.
void MeshScript::identify() {
  if (!has_vertices()) return;
  const Index from = some_vertex(), to = some_vertex();
  for (ElementSpec& e : scene().edit.added)
    if (!has_vertex(e, to)) e.renumber([&](Index v) { return v == from ? to : v; });
}

void MeshScript::reverse() {
  std::vector<ElementSpec>& added = scene().edit.added;
  if (added.empty()) return;
  ElementSpec& e = added[in_.below(added.size())];
  if (e.type == ElementType::polytope) {
    visit_faces(std::span(e.faces), [](std::span<Index> face) { std::reverse(face.begin(), face.end()); });
  } else if (e.type == ElementType::wedge || e.type == ElementType::hexahedron) {
    const auto half = static_cast<std::ptrdiff_t>(e.vertices.size() / 2);
    std::rotate(e.vertices.begin(), e.vertices.begin() + half, e.vertices.end());
  } else if (e.type == ElementType::pyramid || e.type == ElementType::quad) {
    std::swap(e.vertices[1], e.vertices[3]);
  } else {
    std::swap(e.vertices[0], e.vertices[1]);
  }
}

void MeshScript::shuffle() {
  Random random(in_.byte());
  random.shuffle(scene().edit.added);
}

void MeshScript::set_object() { scene().object = in_.byte() % 4; }

void MeshScript::remove() {
  Scene& s = scene();
  const std::uint8_t begin = in_.byte(), count = in_.byte();
  for (int i = 0; i < 1 + count % 16; ++i) {
    if (!s.topology) {
      if (!s.edit.added.empty()) s.edit.added.erase(s.edit.added.begin() + begin % std::ssize(s.edit.added));
      continue;
    }
    const Index slot = (begin + static_cast<Index>(i)) % std::max(s.topology->mesh().element_slots(), 1u);
    if (slot >= s.topology->mesh().element_slots() || !s.topology->mesh().is_live(slot) || s.is_removed(slot)) continue;
    s.edit.removed.push_back(slot);
    s.removed.push_back(s.topology->mesh().spec(slot));
  }
}

/// Adds elements that were removed, with new ids.
void MeshScript::restore() {
  const std::uint8_t count = in_.byte();
  Scene& s = scene();
  for (int i = 0; i < 1 + count % 16 && !s.removed.empty(); ++i) {
    const ElementSpec e = s.removed[count & 128 ? 0 : s.removed.size() - 1];
    s.removed.erase(count & 128 ? s.removed.begin() : s.removed.end() - 1);
    push(e.type, e.vertices, e.faces);
  }
}

/// Control points: 0 the end, 1 the middle one, 2 the start, and 3 all of them.
void MeshScript::set_end(Index v, int control_point, const Vec3& position) {
  Point& p = scene().points[v];
  const Vec3 x = on_lattice(position);
  if (control_point == 0 || control_point == 3) p.end = x;
  if (control_point == 1 || control_point == 3) p.middle = x;
  if (control_point == 2 || control_point == 3) p.start = x;
}

void MeshScript::set_point() {
  const int which = in_.byte() % 4;
  if (!has_vertices()) return;
  const Index v = some_vertex();
  set_end(v, which, fine_point());
}

void MeshScript::move_point() {
  const int which = in_.byte() % 4;
  if (!has_vertices()) return;
  const Index v = some_vertex();
  set_end(v, which, scene().points[v].end + small_vector());
}

void MeshScript::move_range() {
  const int which = in_.byte() % 4;
  if (!has_vertices()) return;
  const Index begin = some_vertex(),
              end = std::min<Index>(begin + 1 + in_.byte() % 32, static_cast<Index>(scene().points.size()));
  const Vec3 by = lattice_point();
  for (Index v = begin; v < end; ++v) set_end(v, which, scene().points[v].end + by);
}

void MeshScript::jitter() {
  const int which = in_.byte() % 4;
  Random random(in_.byte());
  const auto range = static_cast<std::uint64_t>(in_.byte());
  const auto next = [&] { return static_cast<double>(random.below(2 * range + 1)) - static_cast<double>(range); };
  for (Index v = 0; v < scene().points.size(); ++v) {
    const double x = next(), y = next(), z = next();
    set_end(v, which, scene().points[v].end + Vec3(x, y, z));
  }
}

/// Reflects the vertices beyond a plane, or all of them, in this plane: folds, and inversions of the whole mesh.
void MeshScript::mirror() {
  const int what = in_.byte();
  const double at = scale_ * in_.small();
  for (Index v = 0; v < scene().points.size(); ++v) {
    Vec3 p = scene().points[v].end;
    double& x = p[what / 4 % 3];
    if (what & 64 || x > at) x = 2 * at - x;
    set_end(v, what % 4, p);
  }
}

void MeshScript::rest() {
  const int which = in_.byte() % 4;
  for (Index v = 0; v < scene().points.size(); ++v) set_end(v, which, scene().points[v].rest);
}

void MeshScript::set_scene() { current_ = in_.below(scenes_.size()); }

void MeshScript::set_scale() {
  constexpr std::array kScales = {1.0, 4.0, 16.0, 32.0};
  scale_ = kScales[in_.byte() % kScales.size()];
}

void MeshScript::set_filter() {
  constexpr std::array kScopes = {PairScope::all, PairScope::inter, PairScope::intra};
  const std::uint8_t what = in_.byte();
  filter_ = ObjectFilter(kScopes[what % kScopes.size()]);
  if (what & 64) filter_.exclude(what / 4 % 4, what / 16 % 4);
}

void MeshScript::request_step() {
  const std::uint8_t flags = in_.byte();
  options_ = {};
  options_.quadratic = flags & 1;
  if (flags & 2) options_.separation = 0.25 * (1 + in_.byte() % 64);
  if (flags & 4) options_.t_max = in_.byte() / 255.0;
  if (flags & 8) options_.executor = in_.byte();
  options_.first = flags & 16;
  options_.overlaps = flags & 32;
  using Second = StepOptions::Second;
  constexpr std::array kSecond = {Second::none, Second::standard, Second::star_orphans, Second::none};
  options_.second = kSecond[flags >> 6];
  options_.fresh = (flags & 8) || flags >> 6 == 3;
  step_requested_ = has_vertices();
}

std::string MeshScript::text() const {
  const Mesh& mesh = topology().mesh();
  std::string result = fmt::format(
      "step {} of scene {}, topology version {}, separation {}, t_max {:a}, first {}, overlaps {}, second {}, "
      "executor {}, scope {}\nvertices (control points):\n",
      steps_, current_, topology().version(), options_.separation, options_.t_max, options_.first, options_.overlaps,
      static_cast<int>(options_.second), options_.executor, static_cast<int>(filter_.scope()));
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    result += fmt::format("  {}:", v);
    for (int i = 0; i < motion_.control_points(); ++i) {
      const Vec3 p = motion_.point(v, i);
      result += fmt::format(" ({}, {}, {})", p.x(), p.y(), p.z());
    }
    result += '\n';
  }
  result += "elements (slot: type, object, id, vertices, faces):\n";
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    result += fmt::format("  {}: {} {} {},", o, to_string(mesh.type(o)), mesh.object(o), mesh.element_id(o));
    for (const Index v : mesh.vertices(o)) result += fmt::format(" {}", v);
    if (!mesh.polytope_faces(o).empty()) result += ",";
    for (const Index v : mesh.polytope_faces(o)) result += fmt::format(" {}", v);
    result += '\n';
  }
  return result;
}

}  // namespace volccd::fuzz
