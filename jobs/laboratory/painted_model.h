// Models for strokes: a surface and anisotropic samples of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kernels/model/sample_parameters.h"
#include "kernels/rays/embree_locator.h"
#include "kernels/render/stroke_picture.h"
#include "pipeline/sampling_graph.h"

namespace meander {

struct PaintedModel {
  std::vector<double> positions, points;
  std::vector<std::uint32_t> faces;
  std::vector<float> normals, directions, spacings;

  StrokeModel spans() const { return {positions, faces, points, normals, directions, spacings}; }
};

// The parameters of samples of meshes, those of `run --method anisotropic`.
SampleParameters painted_samples(std::uint32_t count, std::uint64_t seed);

// A surface and samples of it in its working units. Throws std::invalid_argument for samples without
// directions.
PaintedModel painted_model(const PreparedMesh& surface, const Row& row);

// Reads and samples a mesh file: the samples are those of `run` with the same parameters. Throws ItemError.
PaintedModel sampled_file(const PlanItem& file, const SampleParameters& parameters,
                          const EmbreeDevice& device);

// The first `count` samples of a row (0: all) on the mesh of `file` if it is that of the row, else on discs
// around all samples instead of a surface; `lacking` then gives the reason. Throws ItemError for a row that
// is not ok.
PaintedModel stored_model(const Row& row, const std::optional<PlanItem>& file, std::uint32_t count,
                          std::string& lacking);

}  // namespace meander
