// Remeshing a model whose samples are placed.
#pragma once

#include "kernels/core/setting.h"
#include "kernels/model/model.h"
#include "kernels/remesh/remesh_surface.h"

namespace meander {

// Makes a mesh in the coordinates of the model's file whose first vertices are the samples of the model, in
// their order. The model has gone through stages_of, with its samples (no leaves_sites) and masses; its
// charts are freed. Vertices that are neither moved nor made by it are, bit by bit, where the samples and the
// file have them. Throws as remesh_surface.
RemeshedSurface remesh_model(Model& model, const RemeshParameters& parameters);

// The settings of meshes: options of `remesh`, and keywords of Python.
const SettingList<RemeshParameters>& remesh_settings();

}  // namespace meander
