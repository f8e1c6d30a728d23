#include <volccd/io/sequence/query_file.hpp>
#include <volccd/oracle/cases/query_set.hpp>

#include "hdf5_script.hpp"
#include "io/sequence/raw_hdf5.hpp"

namespace volccd::fuzz {

namespace {

void write_base(const std::string& name) {
  test::RawFile raw(name, true);
  const std::vector<std::int64_t> zeros(3, 0);
  for (const std::string scene : {"a", "b"}) {
    raw.group(scene);
    for (const std::string& group : {scene + "/VertexFace", scene + "/EdgeEdge"}) {
      raw.group(group);
      raw.put(group + "/Points", {3, 8, 3}, H5T_IEEE_F64LE, std::vector<double>(72, 0.5));
      raw.put(group + "/Collides", {3}, H5T_STD_U8LE, zeros);
      raw.put(group + "/File", {3}, H5T_STD_I32LE, zeros);
      raw.put_attribute(group, "Files", "one two");
    }
  }
}

void read_queries(const std::string& name, std::uint8_t) {
  if (is_sequence_file(name)) return;
  for (const QueryGroup& group : read_query_file(name)) {
    const std::size_t n = group.size();
    if (n == 0 || group.points.size() != 8 * n || group.file.size() != n) promise_broken("arrays of different lengths");
    for (const std::uint32_t file : group.file)
      if (file >= group.file_names.size()) promise_broken("a file without a name");
    if (n <= 1000 && QuerySet(group.kind, 2, group.points).size() != n) promise_broken("a query set of another size");
  }
}

}  // namespace

void query_reader(Bytes bytes) {
  static const std::vector<Image> bases = {image_of(write_base)};
  read_spoilt(bytes, bases, read_queries);
}

}  // namespace volccd::fuzz
