#include "kernels/analyse/histogram_error.h"

#include <cmath>
#include <vector>

#include "support/catch.h"

using namespace meander;

TEST_CASE("histogram_error: a case by hand") {
  const std::vector<double> truth = {0.5, 0.25, 0.25}, measured = {0.25, 0.5, 0.25};
  const HistogramError error = histogram_error(measured, truth);
  CHECK(error.relative == Approx(0.5));
  CHECK(error.largest == Approx(0.25));
  CHECK(error.norm == Approx(std::sqrt(0.125)));
  const HistogramError none = histogram_error(truth, truth);
  CHECK((none.relative == 0 && none.largest == 0 && none.norm == 0));
}
