// Text files with rows for one step after another, of which the steps that were complete are kept.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <volccd/core/output_file.hpp>

namespace volccd {

/// Which steps of those asked for, [begin, end), are complete: [begin, done).
struct StepsDone {
  int begin = 0, done = 0, end = 0;
  std::string stopped_by = {};  ///< why it ended before `end`: "interrupted", or an error; empty: it did not

  bool complete() const { return stopped_by.empty(); }
  /// "steps 0 to 6 of 0 to 20 are complete; interrupted", of one line and without commas and quotation marks, so that
  /// it is one field of a CSV file.
  std::string text() const;
};

/// What the last line of a file starts with that ends before the last step asked for.
inline constexpr std::string_view kIncompleteMark = "# incomplete: ";

/// A header line, then the rows of each step. Atomic, or streamed (OutputFile); the header goes out with the first
/// step, so that a stream that ends before is not taken for a whole file without rows. Throws InputError naming the
/// file. One thread at a time.
class StepTextWriter {
 public:
  StepTextWriter(const std::string& file, std::string_view header);

  const std::string& file() const { return output_.name(); }

  /// `rows`: whole lines. `step` is greater than before. After an error the steps before are kept.
  void write_step(int step, std::string_view rows);
  void finish();
  /// Keeps the complete steps and a last line with kIncompleteMark and steps.text(). On a full disk, steps at the end
  /// are dropped until that line fits. Returns the steps that the file has; where there are none, nothing is written
  /// under its name.
  StepsDone finish_incomplete(StepsDone steps);

 private:
  struct StepEnd {
    int step;
    std::int64_t size;  ///< bytes up to the end of its rows
  };

  void check_open() const;
  void write_header();

  OutputFile output_;
  std::string header_;  ///< with its end of line
  std::vector<StepEnd> ends_;
  bool finished_ = false;
};

}  // namespace volccd
