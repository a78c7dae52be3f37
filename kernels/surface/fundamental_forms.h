// First and second fundamental form of a surface at a point, and the curvatures that follow from them.
#pragma once

#include "kernels/surface/surface.h"

namespace meander {

struct FundamentalForms {
  double E = 0, F = 0, G = 0;  // first form: du.du, du.dv, dv.dv
  double L = 0, M = 0, N = 0;  // second form: duu.n, duv.n, dvv.n
  Vector3 normal;              // unit, along du x dv; zero where the point is degenerate
  double area_element = 0;     // |du x dv| = sqrt(EG - F^2)
  double mean = 0;             // H, positive where the surface bends towards the normal; 1 / length
  double gaussian = 0;         // K, 1 / length^2
  double k1 = 0, k2 = 0;       // principal curvatures, k1 >= k2
};

// The forms at a point (docs/METHODS.md 10; do Carmo 1976, "Differential geometry of curves and surfaces",
// 3-3). Never NaN: where du x dv vanishes or is not finite, normal and area element are 0; where EG - F^2 <=
// 1e-24 times max(E, G)^2 (a pole, to rounding), curvatures and second form are 0. Pure.
FundamentalForms fundamental_forms(const SurfaceJet& jet);

// The area element |du x dv| alone; 0 where it is not finite.
double area_element(Vector3 du, Vector3 dv);

// Unit normal along du x dv; zero where that vanishes.
Vector3 unit_normal(Vector3 du, Vector3 dv);

}  // namespace meander
