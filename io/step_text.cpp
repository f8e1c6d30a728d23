#include <volccd/io/step_text.hpp>

#include <fmt/format.h>

#include <volccd/core/error.hpp>

namespace volccd {

std::string StepsDone::text() const {
  std::string reason = stopped_by;
  for (char& c : reason) {
    if (c == ',') c = ';';
    if (c == '"') c = '\'';
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  const std::string requested = fmt::format("{} to {}", begin, end - 1);
  const std::string kept = done > begin
                               ? fmt::format("{}s {} to {} of {} are complete", unit, begin, done - 1, requested)
                               : fmt::format("no {} of {} is complete", unit, requested);
  return reason.empty() ? kept : kept + "; " + reason;
}

StepTextWriter::StepTextWriter(const std::string& file, std::string_view header)
    : output_(file), header_(std::string(header) + "\n") {}

void StepTextWriter::write_header() {
  if (output_.size() == 0) output_.write(header_);
}

void StepTextWriter::check_open() const {
  if (finished_) throw InputError(file(), "", "has been finished before");
}

void StepTextWriter::write_step(int step, std::string_view rows) {
  check_open();
  if (!ends_.empty() && step <= ends_.back().step)
    throw InputError(file(), "", fmt::format("step {} is written out of order", step));
  const std::int64_t before = output_.size();
  try {
    write_header();
    output_.write(rows);
  } catch (const InputError&) {
    if (!output_.streams()) output_.truncate(before);
    throw;
  }
  ends_.push_back({step, output_.size()});
}

void StepTextWriter::finish() {
  check_open();
  finished_ = true;
  write_header();
  output_.commit();
}

StepsDone StepTextWriter::finish_incomplete(StepsDone steps) {
  check_open();
  finished_ = true;
  while (!ends_.empty() && ends_.back().step >= steps.done) ends_.pop_back();
  for (;;) {
    if (steps.done <= steps.begin && !output_.streams()) return steps;
    try {
      if (!output_.streams()) output_.truncate(ends_.empty() ? 0 : ends_.back().size);
      write_header();
      output_.write(std::string(kIncompleteMark) + steps.text() + "\n");
      break;
    } catch (const InputError&) {
      if (output_.streams() || ends_.empty()) throw;
      steps.done = ends_.back().step;
      ends_.pop_back();
    }
  }
  output_.commit();
  return steps;
}

}  // namespace volccd
