// Functions of the C library whose last bits differ between processors, versions and architectures. Here they
// have the same bits on every machine, by additions, multiplications, divisions and square roots of IEEE 754
// alone.
//
// Names, domains and special values are those of <cmath>; no floating-point exception and no errno is
// promised. Each comment bounds the error, in units in the last place (ulp) of results that are normal
// numbers.
#pragma once

namespace meander::portable {

// Within 0.56 ulp.
double exp(double x);
// Within 0.51 ulp.
double log(double x);
// Within 0.51 ulp, exact for powers of two.
double log2(double x);
// Within 0.57 ulp.
double pow(double x, double y);
// Within 1 ulp.
double cbrt(double x);
// Within 1.25 ulp.
double hypot(double x, double y);
// Within 1.5 ulp.
double hypot(double x, double y, double z);
// In [-pi, pi], within 2.5 ulp; 0 for the zero vector, whatever its signs.
double atan2(double y, double x);

}  // namespace meander::portable
