/* The library for C and for all languages that call C: the Detector (volccd/pipelines/detector.hpp) with plain arrays.
 *
 * Functions return VOLCCD_OK or the code of an error, whose message volccd_last_error() has. No C++ exception leaves a
 * function and none ends the program. After an error, output arguments are unchanged. Sizes are checked against each
 * other and against the mesh; an array must have as many values as its comment says. An array of no values may be NULL.
 *
 * Numbers of vertices and positions in arrays begin with 0. Positions are x, y, z of each vertex: 3 values a vertex.
 *
 * Threads: a detector is used by one thread at a time, also by functions that only read; different detectors are
 * independent. A result belongs to its detector and is valid until that is stepped or freed.
 */
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
  VOLCCD_OK = 0,
  VOLCCD_ERROR_ARGUMENT = 1, /**< NULL, a negative size, or an unknown value of an argument, which the message names */
  VOLCCD_ERROR_INPUT = 2,    /**< bad data: the message names the array and the position in it */
  VOLCCD_ERROR_CONFIG = 3,   /**< a pipeline, setting or value that does not exist or is out of range */
  VOLCCD_ERROR_MEMORY = 4,   /**< out of memory */
  VOLCCD_ERROR_INTERNAL = 5  /**< a defect of the library: please report the message */
};

/** The message of the last call of this thread that failed; empty if none did. Never NULL; valid until the next call of
 * this thread that fails. */
const char* volccd_last_error(void);

/** The version of the library, such as "0.1.0". */
const char* volccd_version(void);

/** Elements in VTK's layout; all arrays are copied. */
typedef struct volccd_cells {
  int64_t count;
  /** [count] triangle 5, quad 9, tetrahedron 10, hexahedron 12, wedge 13, pyramid 14, polyhedron 42 */
  const uint8_t* types;
  const int64_t* offsets; /**< [count + 1] ascending positions in connectivity: first 0, last connectivity_size */
  /** [connectivity_size] vertices in VTK's node order; of a polyhedron each vertex once */
  const int64_t* connectivity;
  int64_t connectivity_size;
  const int64_t* ids;          /**< [count] distinct; NULL: 0 .. count - 1 */
  const int32_t* objects;      /**< [count]; NULL: all belong to object 0 */
  const int64_t* face_offsets; /**< [count + 1] ascending positions in faces; NULL if there are no polyhedra */
  const int64_t* faces;        /**< [faces_size] of each polyhedron: k, v0 .. v(k-1), k, ... in cyclic order */
  int64_t faces_size;
  /** [count] thickness of triangles and quads, which become solids; values of other cells are not read. NULL: shells
   * are surfaces. */
  const double* thickness;
} volccd_cells;

enum { VOLCCD_PAIRS_ALL = 0, VOLCCD_PAIRS_INTER = 1, VOLCCD_PAIRS_INTRA = 2 };
enum { VOLCCD_LISTS_NEVER = 0, VOLCCD_LISTS_AUTO = 1, VOLCCD_LISTS_ALWAYS = 2 };
enum { VOLCCD_EDGES_TRIANGULATED = 0, VOLCCD_EDGES_POLYTOPE = 1 };

/** How contacts are found. All members 0 or NULL: the defaults. */
typedef struct volccd_options {
  const char* pipeline;        /**< NULL: "VolCCD+" */
  const char* const* settings; /**< [setting_count] changes of it: "csat.axis=optimal", "element-culling=csat" */
  int64_t setting_count;
  int32_t threads;         /**< 0: as many as the hardware has */
  int32_t pairs;           /**< VOLCCD_PAIRS_...: contacts of all objects, between objects only, within objects only */
  double separation;       /**< distance at which features are in contact, in the unit of the positions; >= 0 */
  const int32_t* excluded; /**< [2 * excluded_count] pairs of objects without contacts; a, a: within object a */
  int64_t excluded_count;
  int32_t edges;      /**< VOLCCD_EDGES_...: which edges of quads and polygons have contacts */
  int32_t lists;      /**< VOLCCD_LISTS_...: whether candidates of earlier steps are used; contacts are the same */
  double list_budget; /**< of VOLCCD_LISTS_ALWAYS: a distance in the unit of the positions, >= 0 */
  double list_steps;  /**< of VOLCCD_LISTS_ALWAYS: how many steps ahead the motion is expected to go on; 0: to rest */
} volccd_options;

/** A mesh with the pipeline and its tables, which are kept from step to step. */
typedef struct volccd_detector volccd_detector;

/** Makes a detector for a mesh of `vertex_count` vertices. options may be NULL: the defaults. O(cells). */
int volccd_create(int64_t vertex_count, const volccd_cells* cells, const volccd_options* options,
                  volccd_detector** detector);
/** Frees the detector and its results; NULL is allowed. */
void volccd_free(volccd_detector* detector);

/** Changes the mesh between two steps: removes the elements with these ids, appends `new_vertices` vertices, then adds
 * cells (NULL: none), with ids that no remaining element has and, if shells are thickened, with a thickness. After an
 * error nothing has changed. The results of the last step stay. */
int volccd_edit(volccd_detector* detector, const int64_t* removed, int64_t removed_count, int64_t new_vertices,
                const volccd_cells* added);

/** The numbers of vertices and of elements of the mesh; either argument may be NULL. */
int volccd_size(const volccd_detector* detector, int64_t* vertex_count, int64_t* element_count);
/** Holds from the next step on. */
int volccd_set_separation(volccd_detector* detector, double separation);
/** "exact", "conservative" (misses no contact) or "approximate"; valid as long as the detector. */
int volccd_guarantee(const volccd_detector* detector, const char** guarantee);

/** What a step does beside finding contacts: a sum of these. */
enum {
  VOLCCD_STEP_DEFAULT = 0,
  VOLCCD_STEP_FIRST = 1,            /**< finds only the earliest contact, faster */
  VOLCCD_STEP_INITIAL_OVERLAPS = 2, /**< fills volccd_initial_overlaps() */
  VOLCCD_STEP_ENDS = 4              /**< fills volccd_contact_ends() */
};

/** Finds the contacts of the motion of all vertices on straight lines from x0 (time 0) to x1 (time 1), each array of
 * [3 * vertex_count]. Contacts later than t_max, in 0 .. 1, need not be found. After an error there are no results. */
int volccd_step(volccd_detector* detector, int64_t vertex_count, const double* x0, const double* x1, int32_t flags,
                double t_max);
/** The same for constant acceleration: quadratic Bezier curves with the middle control points xm. */
int volccd_step_quadratic(volccd_detector* detector, int64_t vertex_count, const double* x0, const double* xm,
                          const double* x1, int32_t flags, double t_max);

enum { VOLCCD_VF = 0, VOLCCD_EE = 1 };

typedef struct volccd_contact {
  int32_t kind;     /**< VOLCCD_VF: a vertex and a triangle; VOLCCD_EE: two edges */
  int32_t at_start; /**< 1 if the features touch, or are closer than the separation, at time 0; else 0 */
  /** {vertex, triangle} or {edge 1, edge 2}. If shells are thickened, vertices of solids: vertex v stems from v / 3. */
  int64_t vertices[4];
  int64_t elements[2]; /**< at each feature, the incident element of smallest id: its id */
  int32_t objects[2];  /**< objects of these elements */
  double time;         /**< first time of contact in 0 .. 1; never late if the pipeline is conservative */
  double normal[3];    /**< unit normal at this time, from the second feature to the first; 0 where there is none */
  double point[3];     /**< point on the second feature at this time */
  double weights[4];   /**< of the vertices: VF {1, w0, w1, w2}; EE {1 - s, s, 1 - u, u} */
  double gap;          /**< distance of the features at this time */
} volccd_contact;

/** The features of a contact at time 1, which may have passed through each other. */
typedef struct volccd_contact_end {
  double gap;        /**< distance, not signed */
  double weights[4]; /**< of the vertices, for the closest points */
  double first[3];   /**< closest point of the first feature */
  double second[3];  /**< closest point of the second feature */
} volccd_contact_end;

/** The contacts of the last step in canonical order: by kind, then by vertices. The same bits for any number of
 * threads, compiler and processor. Before the first step there are none. Contacts between features of thickened shells
 * that stem from one vertex are not among them. */
int volccd_contacts(const volccd_detector* detector, const volccd_contact** contacts, int64_t* count);
/** With VOLCCD_STEP_ENDS: an entry for each contact, in the same order. */
int volccd_contact_ends(const volccd_detector* detector, const volccd_contact_end** ends, int64_t* count);
/** With VOLCCD_STEP_INITIAL_OVERLAPS: ids of elements that overlap at time 0, [2 * count]. */
int volccd_initial_overlaps(const volccd_detector* detector, const int64_t** pairs, int64_t* count);

/** The earliest contact of the motion on straight lines; the motion is free of contacts before it. found: 1 if there is
 * one, else 0, and contact is unchanged. Faster than volccd_step, whose results it replaces. */
int volccd_first(volccd_detector* detector, int64_t vertex_count, const double* x0, const double* x1,
                 volccd_contact* contact, int32_t* found);

typedef struct volccd_statistic {
  const char* name;
  double value;
} volccd_statistic;

/** Counts and seconds of the last step, by the names of stats.json (docs/json_output.md): "contacts", "earliest_toi"
 * (infinite without contacts), "vf_tests", "seconds", ...; of stages "STAGE.in", "STAGE.out", "STAGE.seconds",
 * "STAGE.prepare_seconds". */
int volccd_statistics(const volccd_detector* detector, const volccd_statistic** entries, int64_t* count);
/** The value of one name. */
int volccd_statistic_value(const volccd_detector* detector, const char* name, double* value);

#ifdef __cplusplus
}
#endif
