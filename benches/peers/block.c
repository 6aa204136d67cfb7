// The block in plain C, 2-D, linear, FLIP: one particle after the other, one thread. `block PARTICLES STEPS REPEATS`
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "problem.h"

typedef struct { double x[2], v[2], s[3], mass, volume; } Particle;

static Particle *particles;
static Node *nodes;

static void scatter(void) {
  for (long p = 0; p < count; p++) {
    const Particle *restrict q = particles + p;
    double x = q->x[0] * inverse, y = q->x[1] * inverse;
    long i = (long)x, j = (long)y;
    x -= i, y -= j;
    double wx[2] = {1 - x, x}, wy[2] = {1 - y, y}, d[2] = {-inverse, inverse};
    double mx = q->mass * q->v[0], my = q->mass * q->v[1];
    double sxx = -q->volume * q->s[0], syy = -q->volume * q->s[1], sxy = -q->volume * q->s[2];
    for (int a = 0; a < 2; a++)
      for (int b = 0; b < 2; b++) {
        Node *restrict n = nodes + (i + a) * width + j + b;
        double w = wx[a] * wy[b], gx = d[a] * wy[b], gy = wx[a] * d[b];
        n->mass += w * q->mass;
        n->a[0] += w * mx, n->a[1] += w * my;
        n->b[0] += sxx * gx + sxy * gy, n->b[1] += sxy * gx + syy * gy;
      }
  }
}

static void gather(void) {
  for (long p = 0; p < count; p++) {
    Particle *restrict q = particles + p;
    double x = q->x[0] * inverse, y = q->x[1] * inverse;
    long i = (long)x, j = (long)y;
    x -= i, y -= j;
    double wx[2] = {1 - x, x}, wy[2] = {1 - y, y}, d[2] = {-inverse, inverse};
    double ax = 0, ay = 0, vx = 0, vy = 0, xx = 0, xy = 0, yx = 0, yy = 0;
    for (int a = 0; a < 2; a++)
      for (int b = 0; b < 2; b++) {
        const Node *restrict n = nodes + (i + a) * width + j + b;
        double w = wx[a] * wy[b], gx = d[a] * wy[b], gy = wx[a] * d[b], u = n->b[0], v = n->b[1];
        ax += w * (u - n->a[0]), ay += w * (v - n->a[1]);
        vx += w * u, vy += w * v;
        xx += u * gx, xy += u * gy, yx += v * gx, yy += v * gy;
      }
    q->x[0] += dt * vx, q->x[1] += dt * vy;
    q->v[0] += ax, q->v[1] += ay;
    double volumetric = xx + yy;
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
  particles = zeroed(count * sizeof(Particle));
  nodes = zeroed(width * width * sizeof(Node));
  Particle *q = particles;
  for (long i = 0; i < cells; i++)
    for (long j = 0; j < cells; j++)
      for (int k = 0; k < 4; k++, q++) {
        q->x[0] = (i + PADDING + .25 + .5 * (k / 2)) / cells, q->x[1] = (j + PADDING + .25 + .5 * (k % 2)) / cells;
        q->volume = .25 / (cells * cells), q->mass = DENSITY * q->volume;
      }
  Rates rates = measure(step);
  double velocity = 0, stress = 0;
  for (long p = 0; p < count; p++) velocity += particles[p].v[1], stress += particles[p].s[1];
  report("C, particle by particle", rates, velocity, stress);
}
