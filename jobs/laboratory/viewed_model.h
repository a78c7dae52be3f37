// A sampled model from many directions: the samples that each view needs, and their splats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "jobs/laboratory/splat_models.h"
#include "kernels/render/view_detail.h"

namespace meander {

class ViewedModel {
 public:
  // The samples, in progressive order, must outlive this object. samples: their number for a view in which
  // the model looks as large as on average over all directions; 0: as many as keep every sample along the
  // silhouette.
  ViewedModel(const Row& row, const ViewDetailParameters& detail, std::uint32_t samples);

  ViewDetail detail(Vector3 towards) const;
  // The share of the kept samples that face away from the eye.
  double behind(const ViewDetail& kept, Vector3 towards) const;
  // Splats are larger where samples are left out, so that they cover the surface as all of them would.
  // colors: of every sample of the row, or one for all.
  RgbImage draw(const ViewDetail& kept, const SplatView& view, const SplatSizes& sizes,
                std::span<const SrgbColor> colors = {&splat_color, 1}) const;

 private:
  const Row& row_;
  ViewDetailParameters parameters_;
  std::vector<float> nx_, ny_, nz_, areas_;
};

// The number of samples of each frame of a turn, and the share of them that the next frame keeps.
class TurnCounts {
 public:
  void add(std::vector<std::uint32_t> kept);  // of the next frame, ascending
  bool steps() const { return !stay_.empty(); }
  double worst() const { return quantile(0); }
  double median() const { return quantile(0.5); }

  std::size_t fewest = std::numeric_limits<std::size_t>::max(), most = 0;

 private:
  double quantile(double q) const;

  std::vector<std::uint32_t> before_;
  std::vector<double> stay_;
};

// The view from another direction with the same scale and center.
void turn(SplatView& view, Vector3 towards, Vector3 up);

}  // namespace meander
