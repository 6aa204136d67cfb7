// The memory's bandwidth in the way of STREAM: a = b + 3 c over arrays beyond the caches, GB/s of what is read and written, the best of REPEATS.
// `triad MIB_PER_ARRAY REPEATS`, threads by OMP_NUM_THREADS.
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv) {
  size_t mib = argc > 1 ? strtoul(argv[1], 0, 10) : 512, n = mib * 1024 * 1024 / 8;
  int repeats = argc > 2 ? atoi(argv[2]) : 10;
  double *a = aligned_alloc(64, n * 8), *b = aligned_alloc(64, n * 8), *c = aligned_alloc(64, n * 8), best = 1e30;
  if (!a || !b || !c) return 1;
  #pragma omp parallel for schedule(static)
  for (size_t i = 0; i < n; i++) a[i] = 0, b[i] = 1, c[i] = 2;
  for (int r = 0; r < repeats; r++) {
    double start = omp_get_wtime();
    #pragma omp parallel for schedule(static)
    for (size_t i = 0; i < n; i++) a[i] = b[i] + 3 * c[i];
    double taken = omp_get_wtime() - start;
    if (taken < best) best = taken;
  }
  printf("{\"threads\": %d, \"gb_per_s\": %.2f, \"check\": %g}\n", omp_get_max_threads(), 24e-9 * n / best, a[n / 2]);
}
