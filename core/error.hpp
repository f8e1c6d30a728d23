// Errors that reach a caller. Programmer errors are asserts; degenerate geometry is no error at all (it gets a
// conservative answer and is counted). What is thrown is thrown where data or configuration enters.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace volccd {

/// Base of everything that this library throws on purpose.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Bad input data: says which file (or other source), which dataset in it, and which index. Exit code 2 of the program.
class InputError : public Error {
 public:
  static constexpr std::int64_t kNoIndex = -1;

  /// `source` is a file name or, for data handed over in memory, a word such as "mesh"; `dataset` may be empty.
  InputError(std::string source, std::string dataset, std::int64_t index, const std::string& problem);
  InputError(std::string source, std::string dataset, const std::string& problem)
      : InputError(std::move(source), std::move(dataset), kNoIndex, problem) {}

  const std::string& source() const { return source_; }
  const std::string& dataset() const { return dataset_; }
  std::int64_t index() const { return index_; }

 private:
  std::string source_, dataset_;
  std::int64_t index_;
};

/// A stage, option or combination that does not exist or whose completeness argument does not hold. Exit code 2.
class ConfigError : public Error {
 public:
  using Error::Error;
};

}  // namespace volccd
