// The limit: the block in C, 2-D, linear, FLIP, particles bound to their cells. A cell's four particles are the lanes of a vector; its nodes are summed
// in registers. Particles must stay in their cells, which is checked at the end; a real program has to bring them to new ones.
// `block_by_cell PARTICLES STEPS REPEATS`
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "problem.h"

typedef double Lanes __attribute__((vector_size(32)));
typedef struct { Lanes x[2], v[2], s[3], mass, volume; } Cell;

static Cell *ground;
static Node *nodes;

static void scatter(void) {
  const Lanes dx = {-inverse, -inverse, inverse, inverse}, dy = {-inverse, inverse, -inverse, inverse};
  for (long i = 0; i < cells; i++)
    for (long j = 0; j < cells; j++) {
      const Cell *q = ground + i * cells + j;
      Lanes x = q->x[0] * inverse - (double)(i + PADDING), y = q->x[1] * inverse - (double)(j + PADDING);
      Lanes mx = q->mass * q->v[0], my = q->mass * q->v[1];
      Lanes sxx = -q->volume * q->s[0], syy = -q->volume * q->s[1], sxy = -q->volume * q->s[2];
      // Lanes are nodes now.
      Lanes mass = {0}, ax = {0}, ay = {0}, bx = {0}, by = {0};
      #pragma GCC unroll 4
      for (int k = 0; k < 4; k++) {
        Lanes wx = {1 - x[k], 1 - x[k], x[k], x[k]}, wy = {1 - y[k], y[k], 1 - y[k], y[k]};
        Lanes w = wx * wy, gx = dx * wy, gy = wx * dy;
        mass += w * q->mass[k], ax += w * mx[k], ay += w * my[k];
        bx += sxx[k] * gx + sxy[k] * gy, by += sxy[k] * gx + syy[k] * gy;
      }
      Node *first = nodes + (i + PADDING) * width + j + PADDING;
      #pragma GCC unroll 4
      for (int k = 0; k < 4; k++) {
        Node *n = first + k / 2 * width + k % 2;
        n->mass += mass[k], n->a[0] += ax[k], n->a[1] += ay[k], n->b[0] += bx[k], n->b[1] += by[k];
      }
    }
}

static void gather(void) {
  for (long i = 0; i < cells; i++)
    for (long j = 0; j < cells; j++) {
      Cell *q = ground + i * cells + j;
      const Node *first = nodes + (i + PADDING) * width + j + PADDING;
      Lanes x = q->x[0] * inverse - (double)(i + PADDING), y = q->x[1] * inverse - (double)(j + PADDING);
      Lanes zero = {0}, ax = zero, ay = zero, vx = zero, vy = zero, xx = zero, xy = zero, yx = zero, yy = zero;
      #pragma GCC unroll 4
      for (int k = 0; k < 4; k++) {
        const Node *n = first + k / 2 * width + k % 2;
        Lanes wx = k / 2 ? x : 1 - x, wy = k % 2 ? y : 1 - y;
        double dx = k / 2 ? inverse : -inverse, dy = k % 2 ? inverse : -inverse, u = n->b[0], v = n->b[1];
        Lanes w = wx * wy, gx = dx * wy, gy = dy * wx;
        ax += w * (u - n->a[0]), ay += w * (v - n->a[1]), vx += w * u, vy += w * v;
        xx += u * gx, xy += u * gy, yx += v * gx, yy += v * gy;
      }
      q->x[0] += dt * vx, q->x[1] += dt * vy, q->v[0] += ax, q->v[1] += ay;
      Lanes volumetric = xx + yy;
      q->s[0] += dt * (LAME * volumetric + 2 * SHEAR * xx);
      q->s[1] += dt * (LAME * volumetric + 2 * SHEAR * yy);
      q->s[2] += dt * SHEAR * (xy + yx);
      q->volume *= 1 + dt * volumetric;
    }
}

static void step(void) {
  memset(nodes, 0, width * width * sizeof(Node));
  scatter();
  advance_nodes(nodes);
  gather();
}

int main(int argc, char **argv) {
  problem(argc, argv);
  ground = zeroed(cells * cells * sizeof(Cell));
  nodes = zeroed(width * width * sizeof(Node));
  for (long c = 0; c < cells * cells; c++)
    for (int k = 0; k < 4; k++) {
      ground[c].x[0][k] = (c / cells + PADDING + .25 + .5 * (k / 2)) / cells;
      ground[c].x[1][k] = (c % cells + PADDING + .25 + .5 * (k % 2)) / cells;
      ground[c].volume[k] = .25 / (cells * cells), ground[c].mass[k] = DENSITY * ground[c].volume[k];
    }
  Rates rates = measure(step);
  double velocity = 0, stress = 0;
  for (long c = 0; c < cells * cells; c++)
    for (int k = 0; k < 4; k++) {
      const Cell *q = ground + c;
      velocity += q->v[1][k], stress += q->s[1][k];
      if ((long)(q->x[0][k] * inverse) != c / cells + PADDING || (long)(q->x[1][k] * inverse) != c % cells + PADDING) {
        fprintf(stderr, "a particle has left its cell\n");
        return 1;
      }
    }
  report("C, by cell", rates, velocity, stress);
}
