#include "hdf5_script.hpp"

#include <cstdlib>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include <sys/stat.h>
#include <unistd.h>

#include <volccd/core/error.hpp>

#include "byte_reader.hpp"
#include "io/sequence/raw_hdf5.hpp"

namespace volccd::fuzz {

namespace {

/// HDF5 needs a path that it can resolve; a memfd has none.
std::string memory_folder() {
  return std::filesystem::is_directory("/dev/shm") ? "/dev/shm" : std::filesystem::temp_directory_path().string();
}

}  // namespace

MemoryFile::MemoryFile(Bytes image) : name_(memory_folder() + "/volccd-fuzz-XXXXXX") {
  descriptor_ = ::mkstemp(name_.data());
  if (descriptor_ < 0) throw std::runtime_error("no file in memory");
  for (std::size_t at = 0; at < image.size();) {
    const ssize_t n = ::write(descriptor_, image.data() + at, image.size() - at);
    if (n <= 0) throw std::runtime_error("no room for a file in memory");
    at += static_cast<std::size_t>(n);
  }
}

MemoryFile::~MemoryFile() {
  ::close(descriptor_);
  ::unlink(name_.c_str());
}

Image MemoryFile::image() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) throw std::runtime_error("no file in memory");
  Image bytes(static_cast<std::size_t>(status.st_size));
  if (::pread(descriptor_, bytes.data(), bytes.size(), 0) != status.st_size) throw std::runtime_error("short read");
  return bytes;
}

Image image_of(const std::function<void(const std::string& name)>& write) {
  const MemoryFile file({});
  write(file.name());
  return file.image();
}

namespace {

/// Datasets that are declared but not stored are not read for an edit.
constexpr std::size_t kMaxNumbers = 100000;

std::int64_t telling_integer(ByteReader& in) {
  switch (in.byte() % 5) {
    case 0: return in.small();
    case 1: return std::int64_t{1} << in.below(63);
    case 2: return std::numeric_limits<std::int64_t>::max() - in.byte();
    case 3: return -(std::int64_t{1} << in.below(63));
    default: return static_cast<std::int64_t>(in.bits(8));
  }
}

double telling_real(ByteReader& in) {
  switch (in.byte() % 4) {
    case 0: return in.small();
    case 1: return std::numeric_limits<double>::quiet_NaN();
    case 2: return in.byte() % 2 ? 1e308 : -std::numeric_limits<double>::infinity();
    default: return in.any_double();
  }
}

std::vector<hsize_t> shape(ByteReader& in) {
  std::vector<hsize_t> dims(in.below(4));
  for (hsize_t& d : dims) d = in.byte() % 8 == 0 ? hsize_t{1} << in.below(50) : in.byte() % 40;
  return dims;
}

bool is_real(const test::RawFile& file, const std::string& path) {
  const hid_t type = H5Dget_type(file.open(path));
  const bool real = H5Tget_class(type) == H5T_FLOAT;
  H5Tclose(type);
  return real;
}

void declare_anew(test::RawFile& file, const std::string& path, ByteReader& in) {
  const hid_t types[] = {H5T_STD_I64LE, H5T_STD_U8LE, H5T_IEEE_F64LE, H5T_STD_U64BE, H5T_IEEE_F32LE};
  const hid_t type = types[in.below(5)];
  const std::vector<hsize_t> dims = shape(in);
  hsize_t size = 1;
  for (const hsize_t d : dims) size = d > 1000 / std::max<hsize_t>(size, 1) ? 1000 : size * d;
  // The data would be too large, so that the dataset is only declared.
  if (size >= 1000) return file.put_empty(path, dims, type, in.byte() % 2 == 0 && !dims.empty());
  if (file.count(path) > kMaxNumbers) return;
  const std::vector<double> old = is_real(file, path) ? file.reals(path) : std::vector<double>();
  if (old.empty())
    file.put(path, dims, type, file.integers(path));
  else
    file.put(path, dims, type, old);
}

void change_attribute(test::RawFile& file, const std::string& object, ByteReader& in) {
  const char* names[] = {"NSteps", "Version", "Type", "Files", "Parts", "Title"};
  const std::string name = names[in.below(6)];
  switch (in.byte() % 3) {
    case 0: return file.remove_attribute(object, name);
    case 1: return file.put_attribute(object, name, std::vector<std::int64_t>(1 + in.below(3), telling_integer(in)));
    default: {
      std::string text;
      for (std::size_t n = in.below(24); n > 0; --n) text += static_cast<char>(in.byte());
      return file.put_attribute(object, name, text, in.byte() % 2 == 0);
    }
  }
}

void edit(test::RawFile& file, const std::vector<std::string>& objects, ByteReader& in) {
  const std::uint8_t what = in.byte() % 8;
  const std::string& path = objects[in.below(objects.size())];
  switch (what) {
    case 0: return file.remove(path);
    case 1: return declare_anew(file, path, in);
    case 2: return change_attribute(file, in.byte() % 2 ? path : std::string("/"), in);
    default: {
      const std::size_t n = file.count(path);
      if (n == 0 || n > kMaxNumbers) return;
      const std::size_t at = in.below(n);
      if (is_real(file, path))
        file.poke(path, at, telling_real(in));
      else
        file.poke(path, at, telling_integer(in));
    }
  }
}

void apply_edits(const std::string& name, std::size_t edits, ByteReader& in) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  test::RawFile file(name);
  const std::set<std::string> all = file.objects();
  const std::vector<std::string> objects(all.begin(), all.end());
  for (; edits > 0 && !in.empty(); --edits) {
    try {
      edit(file, objects, in);
    } catch (const std::exception&) {  // HDF5 refuses the edit, or an earlier edit has removed the object
    }
  }
}

}  // namespace

void read_spoilt(Bytes bytes, const std::vector<Image>& bases,
                 const std::function<void(const std::string& name, std::uint8_t choice)>& read) {
  const auto try_read = [&](const std::string& name, std::uint8_t choice) {
    try {
      read(name, choice);
    } catch (const InputError&) {
    }
  };
  if (bytes.size() >= 4 && bytes[0] == 0x89 && bytes[1] == 'H' && bytes[2] == 'D' && bytes[3] == 'F') {
    const MemoryFile file(bytes);
    return try_read(file.name(), bytes.back());
  }
  ByteReader in(bytes);
  const Image& base = bases[in.below(bases.size())];
  const std::uint8_t choice = in.byte();
  const std::size_t edits = in.byte() % 17;
  const MemoryFile file(base);
  apply_edits(file.name(), edits, in);
  try_read(file.name(), choice);
}

}  // namespace volccd::fuzz
