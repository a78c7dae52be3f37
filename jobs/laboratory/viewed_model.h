// A sampled model seen from many directions: the samples that each view asks for, and their splats.
#pragma once

#include <cstdint>
#include <vector>

#include "jobs/laboratory/splat_models.h"
#include "kernels/render/view_detail.h"

namespace meander {

class ViewedModel {
 public:
  // The samples in progressive order, which must outlive this. samples: of a view from which the model looks
  // as large as on the mean over all directions; 0: as many as take every sample along the silhouette.
  ViewedModel(const Row& row, const ViewDetailParameters& detail, std::uint32_t samples);

  ViewDetail detail(Vector3 towards) const;
  // Splats grow where samples are left out, so that they cover the surface as all of them would.
  RgbImage draw(const ViewDetail& kept, const SplatView& view, const SplatSizes& sizes) const;

 private:
  const Row& row_;
  ViewDetailParameters parameters_;
  std::vector<float> nx_, ny_, nz_, areas_;
};

// The view from another direction; scale and centre stay.
void turn(SplatView& view, Vector3 towards, Vector3 up);

}  // namespace meander
