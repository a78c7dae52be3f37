#include "kernels/analyse/histogram_error.h"

#include <cmath>

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

TEST_CASE("spread_of: mean, deviation with n - 1, standard error, and gaps in errors of the difference") {
  const Spread spread = spread_of({1, 2, 3, 4});
  CHECK(spread.mean == Approx(2.5));
  CHECK(spread.deviation == Approx(std::sqrt(5.0 / 3)));
  CHECK(spread.error == Approx(std::sqrt(5.0 / 12)));
  const Spread one = spread_of({7});
  CHECK((one.mean == 7 && one.deviation == 0 && one.error == 0));
  CHECK(gap_of({3, 0, 3}, {8, 0, 4}) == Approx(-1));
  CHECK(spread_of({}).mean == 0);
}
