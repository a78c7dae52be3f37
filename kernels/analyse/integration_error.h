// Error of quasi-Monte Carlo integration with a sample set: what low discrepancy is wanted for.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace meander {

// Notation: f is known at n samples whose density is proportional to phi; mu(R) = integral of phi over R,
// M = mu(whole domain). All sums run in fixed blocks (deterministic for every thread count), O(n). All throw
// std::invalid_argument on an empty set, different lengths, or densities that are not positive.

// | mean(f) - exact |, with exact = integral(f phi) / M: the mean value of f under the samples' own measure.
double integration_error(std::span<const double> values, double exact);

// | (M / n) sum f / phi - exact |, with exact = integral(f) over the domain: importance sampling. density:
// phi at the samples; measure: M.
double weighted_integration_error(std::span<const double> values, std::span<const double> density,
                                  double measure, double exact);

// integration_error of the first counts[i] values (ascending, >= 1), for samples in progressive order. O(n).
std::vector<double> prefix_integration_errors(std::span<const double> values,
                                              std::span<const std::uint64_t> counts, double exact);

// The mean of f over the domain as samples give it: the mean of the values, or with their density (any
// multiple of phi; empty: uniform) the self-normalized sum f / phi : sum 1 / phi, for which M need not be
// known.
double mean_estimate(std::span<const double> values, std::span<const double> density = {});

struct ErrorSummary {
  double rms = 0, largest = 0;    // of the absolute values
  double standard_deviation = 0;  // about their mean; 0 for one error
};
// Summarizes one or more signed errors.
ErrorSummary summarize_errors(std::span<const double> errors);

// Test functions on [0, 1]^2 with their integrals in closed form. All are smooth or piecewise constant and
// none is periodic or symmetric, so that no method is favored by its grid.
struct Integrand {
  std::string_view name;
  double (*value)(double x, double y);
  double (*density)(double x, double y);  // the phi that samples must follow; 1 for uniform sets
  double density_integral;                // M
  double mean;                            // integral(f phi) / M
  double variance;                        // of f under phi / M: n samples at random have RMS error sqrt(./n)
};
// exponential, cosine (smooth, uniform); disc, half-plane (indicators, uniform); weighted (exp(x + y) under
// phi = x^2 y^2, the density of Quinn et al. 2013).
std::span<const Integrand> standard_integrands();

}  // namespace meander
