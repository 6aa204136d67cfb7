/* The same law as elastic.f, for machines without a Fortran compiler. */
#include <stddef.h>
#include <string.h>
void umat_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
           double *ddsddt, double *drplde, double *drpldt, const double *stran, const double *dstran,
           const double *time, const double *dtime, const double *temp, const double *dtemp, const double *predef,
           const double *dpred, const char *cmname, const int *ndi, const int *nshr, const int *ntens,
           const int *nstatv, const double *props, const int *nprops, const double *coords, const double *drot,
           double *pnewdt, const double *celent, const double *dfgrd0, const double *dfgrd1, const int *noel,
           const int *npt, const int *layer, const int *kspt, const int *kstep, const int *kinc, size_t length) {
  const double g = props[0] / (2.0 * (1.0 + props[1]));
  const double lame = props[0] * props[1] / ((1.0 + props[1]) * (1.0 - 2.0 * props[1]));
  int moved = 0;
  memset(ddsdde, 0, 36 * sizeof(double));
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) ddsdde[6 * i + j] = lame;
    ddsdde[7 * i] += 2.0 * g;
    ddsdde[7 * (i + 3)] = g;
  }
  for (int i = 0; i < 6; i++) {
    for (int j = 0; j < 6; j++) stress[i] += ddsdde[6 * j + i] * dstran[j];
    moved |= dstran[i] != 0.0;
  }
  if (*nstatv >= 4) {
    const double old[3] = {statev[1], statev[2], statev[3]};
    if (moved) statev[0] += 1.0;
    for (int i = 0; i < 3; i++) statev[1 + i] = drot[i] * old[0] + drot[3 + i] * old[1] + drot[6 + i] * old[2];
  }
  if (length >= 5 && strncmp(cmname, "SHORT", 5) == 0) *pnewdt = 0.5;
}
