/* A cube of springs falls onto a fixed plate and bounces: an explicit loop with penalty forces from the contacts that
 * the library finds. Prints the contacts of each twentieth step and, at the end, totals. docs/into_a_solver.md explains
 * it; examples/fortran/bouncing_cube.f90 prints the same. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <volccd.h>

enum { PLATE = 8, VERTICES = 16, STEPS = 400 };

static const double h = 1e-3, mass = 1, gravity = -9.81;
static const double stiffness = 2e4, penalty = 4e3, separation = 0.05;

/* Ends the program if a call failed. */
static void check(int code) {
  if (code == VOLCCD_OK) return;
  fprintf(stderr, "error %d: %s\n", code, volccd_last_error());
  exit(2);
}

/* A box of one hexahedron in VTK's node order. */
static void set_box(double* x, const double low[3], const double high[3]) {
  static const int corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  for (int v = 0; v < 8; ++v)
    for (int i = 0; i < 3; ++i) x[3 * v + i] = corners[v][i] ? high[i] : low[i];
}

static volccd_detector* make_detector(void) {
  static const uint8_t types[] = {12, 12}; /* hexahedra */
  static const int64_t offsets[] = {0, 8, 16};
  static const int64_t connectivity[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  static const int32_t objects[] = {1, 2};
  volccd_cells cells = {0};
  cells.count = 2;
  cells.types = types;
  cells.offsets = offsets;
  cells.connectivity = connectivity;
  cells.connectivity_size = VERTICES;
  cells.objects = objects;
  volccd_options options = {0};
  options.separation = separation;
  options.pairs = VOLCCD_PAIRS_INTER;
  options.lists = VOLCCD_LISTS_AUTO;
  volccd_detector* detector = NULL;
  check(volccd_create(VERTICES, &cells, &options, &detector));
  return detector;
}

/* A spring between each two vertices of the cube. They are linear in the change of the distance vector, which suits a
 * cube that hardly turns. */
static void add_springs(const double* rest, const double* x, double* force) {
  for (int a = PLATE; a < VERTICES; ++a)
    for (int b = a + 1; b < VERTICES; ++b)
      for (int i = 0; i < 3; ++i) {
        const double pull = stiffness * ((x[3 * b + i] - x[3 * a + i]) - (rest[3 * b + i] - rest[3 * a + i]));
        force[3 * a + i] += pull;
        force[3 * b + i] -= pull;
      }
}

/* The force on the first feature is along the normal, proportional to what lacks to the separation at the end of the
 * step; the weights of the contact share it among the vertices. The second feature gets the opposite force. */
static void add_contact(const volccd_contact* contact, const volccd_contact_end* end, double* force) {
  const double size = penalty * (separation - end->gap);
  const int first = contact->kind == VOLCCD_VF ? 1 : 2; /* vertices of the first feature */
  if (size <= 0) return;
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < 3; ++i)
      force[3 * contact->vertices[k] + i] += (k < first ? size : -size) * contact->weights[k] * contact->normal[i];
}

static void print_contact(int step, const volccd_contact* c, const volccd_contact_end* end) {
  printf("%d %s %d %d %d %d  time %.6f  end gap %.6f  normal %6.3f %6.3f %6.3f\n", step,
         c->kind == VOLCCD_VF ? "VF" : "EE", (int)c->vertices[0], (int)c->vertices[1], (int)c->vertices[2],
         (int)c->vertices[3], c->time, end->gap, c->normal[0], c->normal[1], c->normal[2]);
}

int main(void) {
  double rest[3 * VERTICES], x0[3 * VERTICES], x1[3 * VERTICES], v[3 * VERTICES] = {0};
  int64_t total = 0;
  set_box(rest, (const double[]){-2, -2, -1}, (const double[]){2, 2, 0});
  set_box(rest + 3 * PLATE, (const double[]){-0.5, -0.4, 0.12}, (const double[]){0.5, 0.6, 1.12});
  for (int i = 0; i < 3 * VERTICES; ++i) x0[i] = rest[i];
  volccd_detector* detector = make_detector();
  for (int step = 0; step < STEPS; ++step) {
    for (int i = 0; i < 3 * VERTICES; ++i) x1[i] = x0[i] + h * v[i];
    const volccd_contact* contacts;
    const volccd_contact_end* ends;
    int64_t count, end_count;
    check(volccd_step(detector, VERTICES, x0, x1, VOLCCD_STEP_ENDS, 1.0));
    check(volccd_contacts(detector, &contacts, &count));
    check(volccd_contact_ends(detector, &ends, &end_count));
    double force[3 * VERTICES] = {0};
    add_springs(rest, x1, force);
    for (int64_t k = 0; k < count; ++k) {
      add_contact(&contacts[k], &ends[k], force);
      if (step % 20 == 0) print_contact(step, &contacts[k], &ends[k]);
    }
    total += count;
    for (int i = 3 * PLATE; i < 3 * VERTICES; ++i)
      v[i] += h * (force[i] / mass + (i % 3 == 2 ? gravity : 0)); /* the plate is fixed */
    for (int i = 0; i < 3 * VERTICES; ++i) x0[i] = x1[i];
  }
  printf("%lld contacts, height %.6f\n", (long long)total, x0[3 * PLATE + 2]);
  volccd_free(detector);
  return 0;
}
