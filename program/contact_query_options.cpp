#include <volccd/program/contact_query_options.hpp>

namespace volccd {

void ContactQueryOptions::add_to(CLI::App& command) {
  sequence.add_to(command);
  command.add_option("--pipeline", pipeline, "see `volccd stages`")->type_name("NAME")->capture_default_str();
  command.add_option("--set", settings, "stage.option=value, or role=stage[,stage...]; may be repeated")
      ->type_name("X=Y")
      ->allow_extra_args(false);
  command.add_option("--contacts", contacts, "write the contacts as CSV")->type_name("FILE");
  command
      .add_option("--overlaps", overlaps,
                  "also find the elements that overlap at the start of a step, and write them as CSV")
      ->type_name("FILE");
  command.add_option("--stats", stats, "write counts and times as JSON")->type_name("FILE");
  command.add_flag("--first", first, "find only the earliest contact of each step, which is faster");
  query.add_to(command);
  sequence.add_parts_to(command);
}

Request ContactQueryOptions::request() const {
  return {.query = first ? Query::first : Query::all,
          .initial_overlaps = !overlaps.empty(),
          .leave_out_shell_neighbours = query.leaves_out_shell_neighbours(sequence)};
}

}  // namespace volccd
