// The block of problem.py for the programs in C, the step of its nodes, and the line of JSON about it.
#include <time.h>

enum { PADDING = 3, WARM = 5 };
#define DENSITY 1000.0
#define YOUNG 1e7
#define POISSON 0.3
#define LAME (YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)))
#define SHEAR (YOUNG / (2 * (1 + POISSON)))
#define GRAVITY (-9.81)

// a: momentum, then velocity before the step; b: force, then velocity after it.
typedef struct { double mass, a[2], b[2]; } Node;

static long cells, count, width, steps, repeats;
static double inverse, dt;

static void problem(int argc, char **argv) {
  cells = lround(sqrt((argc > 1 ? atol(argv[1]) : 100000) / 4.0));
  steps = argc > 2 ? atol(argv[2]) : 100;
  repeats = argc > 3 ? atol(argv[3]) : 3;
  count = 4 * cells * cells, width = cells + 2 * PADDING + 1, inverse = cells;
  dt = 0.2 / cells / sqrt((LAME + 2 * SHEAR) / DENSITY);
}

static void *zeroed(size_t bytes) {
  bytes = (bytes + 63) / 64 * 64;
  void *memory = aligned_alloc(64, bytes);
  if (!memory) exit(1);
  return memset(memory, 0, bytes);
}

static void advance_nodes(Node *nodes) {
  for (long i = 0; i < width; i++)
    for (long j = 0; j < width; j++) {
      Node *n = nodes + i * width + j;
      if (n->mass <= 0) continue;
      double per = 1 / n->mass, ax = n->a[0] * per, ay = n->a[1] * per;
      double bx = ax + dt * n->b[0] * per, by = ay + dt * (n->b[1] * per + GRAVITY);
      if (i <= PADDING || i >= PADDING + cells) ax = bx = 0;
      if (j <= PADDING) ay = by = 0;
      n->a[0] = ax, n->a[1] = ay, n->b[0] = bx, n->b[1] = by;
    }
}

static double seconds(clockid_t of) {
  struct timespec t;
  clock_gettime(of, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

// Particle-steps per second, the median, and per second of the processor.
typedef struct { double wall, cpu; } Rates;

static Rates measure(void (*step)(void)) {
  double *taken = zeroed(repeats * sizeof(double));
  for (int k = 0; k < WARM; k++) step();
  double before = seconds(CLOCK_PROCESS_CPUTIME_ID);
  for (long r = 0; r < repeats; r++) {
    double start = seconds(CLOCK_MONOTONIC);
    for (long k = 0; k < steps; k++) step();
    taken[r] = seconds(CLOCK_MONOTONIC) - start;
  }
  double cpu = seconds(CLOCK_PROCESS_CPUTIME_ID) - before;
  qsort(taken, repeats, sizeof(double), ascending);
  return (Rates){count * steps / taken[repeats / 2], count * steps * repeats / cpu};
}

static void report(const char *tool, Rates rates, double velocity, double stress) {
  printf("{\"tool\": \"%s\", \"dim\": 2, \"shape\": \"linear\", \"threads\": 1, \"particles\": %ld, \"particle_steps_per_s\": %.0f, "
         "\"particle_steps_per_cpu_s\": %.0f, \"check\": {\"total_steps\": %ld, \"mean_v\": %.17g, \"probe\": %.17g}}\n",
         tool, count, rates.wall, rates.cpu, WARM + steps * repeats, velocity / count, stress / count);
}
