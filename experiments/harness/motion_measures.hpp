// Measures of a motion that do not depend on the pipeline: numbers of pairs, displacements, hashes.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <volccd/mesh/topology.hpp>
#include <volccd/query/contact.hpp>
#include <volccd/query/motion.hpp>

namespace volccd {

/// Number of pairs of elements with a common vertex, each element with itself included. A broad phase over all pairs
/// emits all of them, since swept volumes with a common vertex overlap. O(elements x neighbours).
std::uint64_t adjacent_pair_count(const Topology& topology);

/// Number of non-adjacent element pairs that contain at least one of the contacts: one element has the first feature,
/// the other the second. O(contacts x elements at a feature).
std::uint64_t touching_pair_count(const Topology& topology, std::span<const Contact> contacts);

/// Mean length of the edges in use at t = 0; 0 if there are none.
double mean_edge_length(const Features& features, const Motion& motion);

/// Mean displacement of the vertices in use, in mean edge lengths at t = 0.
double mean_moved_edges(const Features& features, const Motion& motion);

/// 64-bit FNV-1a of kinds, vertices and times, as hexadecimal text: equal for equal contacts, bit for bit.
std::string contacts_hash(std::span<const Contact> contacts);

/// The same hash of a file's bytes. Throws InputError.
std::string file_hash(const std::string& file);

/// All control points are x0 + scale (x - x0).
Motion scaled(const Motion& motion, double scale);

}  // namespace volccd
