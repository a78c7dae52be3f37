// The options of the method anisotropic: where its tensor field comes from.
#pragma once

#include <string>
#include <vector>

#include "jobs/parameter_table.h"
#include "kernels/model/sample_parameters.h"
#include "pipeline/sampling_graph.h"

namespace meander {

struct TensorOptionTexts {
  std::string tensor = "curvature";
  bool chooses_segments = false;
  std::string given;   // the first of these options that was given; empty: none
  std::string folder;  // that a relative path of file:PATH begins in; empty: the working folder
};

// Adds the options under the heading "Anisotropic". `table` gets what the store of an anisotropic run
// records.
void add_tensor_options(const Command& command, ParameterTable& table, TensorOptionTexts& texts,
                        SampleParameters& parameters);

// Fills parameters.tensor and adds what is wrong to `problems`, also options that the method does not take.
void resolve_tensor_options(const TensorOptionTexts& texts, SampleParameters& parameters,
                            std::vector<std::string>& problems);

// Where the tensors of each item of `--tensor file:PATH` are: one text file for all; in a folder ID.txt (or
// with .txt in place of the mesh's extension); in an HDF5 file (.h5, .hdf5) the dataset of the item's id.
void plan_tensor_files(const TensorParameters& tensor, std::vector<PlanItem>& items);

// "curvature", "attribute:NAME", "constant:1,0,0,1,0,1", ...: as the user would give it.
std::string tensor_text(const TensorParameters& tensor);

}  // namespace meander
