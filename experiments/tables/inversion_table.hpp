// The inversion test as a check for self-collisions, and what it misses (Section 7.2, "Flip methods").
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// The scenes of the tables, for their inputs only: the plan has no windows.
ExperimentPlan inversion_plan(const PlanContext& context);

/// One row for each step of the scenes of the tables, linear, and tentative where the file has velocities; contacts
/// are those of VolCCD+. Columns: scene, motion_model, motion, elements, and as count_inversions() returns them.
void inversion_rows(const PlanContext& context, RecordFile& record);
std::vector<TitledTable> inversion_tables(const nlohmann::json& record);

/// Compares the contacts of a step within its objects with the elements that invert (harness/corner_volumes.hpp):
///   examined           elements for which there is an inversion test
///   inverted_at_start  elements that are inverted or flat at some corner at t = 0
///   inverting          elements that are not, and become so during the step
///   touching_inside    of both: elements that have both features of a contact (a vertex and a face of their own, or
///                      two edges)
///   intra              contacts between features of one object
///   intra_at_start     of those, contacts that touch at t = 0; the three numbers below are of the others
///   in_inverted        both features belong to one element that is inverted or inverts: the test points at the contact
///   at_inverted        not so, but an element at one of the features is inverted or inverts
///   missed             all others: the test says nothing about them
/// Pre: the motion has two control points.
nlohmann::json count_inversions(const Step& step, std::span<const Contact> contacts);

}  // namespace volccd
