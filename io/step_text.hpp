// Text files with rows for consecutive steps. If the program stops early, the rows of the completed steps are kept.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <volccd/io/output_file.hpp>

namespace volccd {

/// Of the requested steps [begin, end), the steps [begin, done) are complete.
struct StepsDone {
  int begin = 0, done = 0, end = 0;
  std::string stopped_by = {};  ///< why the run ended before `end`: "interrupted" or an error message; empty if it did
                                ///< not
  const char* unit = "step";    ///< what is counted, for text(): "step" or "frame"

  bool complete() const { return stopped_by.empty(); }
  /// For example "steps 0 to 6 of 0 to 20 are complete; interrupted". One line without commas and quotation marks, so
  /// that it can be one field of a CSV file.
  std::string text() const;
};

/// Start of the last line of a file that ends before the last requested step.
inline constexpr std::string_view kIncompleteMark = "# incomplete: ";

/// Writes a header line, then the rows of each step. A regular file appears under its name only when it is finished; a
/// device, FIFO or descriptor is written to immediately (OutputFile). The header is written together with the first
/// step, so that output which ends before the first step is not mistaken for a complete file without rows. Throws
/// InputError that names the file. Not thread-safe.
class StepTextWriter {
 public:
  StepTextWriter(const std::string& file, std::string_view header);

  const std::string& file() const { return output_.name(); }

  /// `rows` consists of whole lines; `step` must be greater than in the previous call. After an error, the rows of the
  /// previous steps are kept.
  void write_step(int step, std::string_view rows);
  void finish();
  /// Keeps the rows of the complete steps and appends a last line of kIncompleteMark and steps.text(). On a full disk,
  /// the last steps are dropped until that line fits. Returns the steps that the file contains; if there are none, no
  /// file is written.
  StepsDone finish_incomplete(StepsDone steps);

 private:
  struct StepEnd {
    int step;
    std::int64_t size;  ///< size of the file up to the end of the rows of this step
  };

  void check_open() const;
  void write_header();

  OutputFile output_;
  std::string header_;  ///< includes the end of line
  std::vector<StepEnd> ends_;
  bool finished_ = false;
};

}  // namespace volccd
