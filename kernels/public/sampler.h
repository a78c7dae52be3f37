// <meander/sampler.h>: sampling meshes from a C++ program. See Sampler.
#pragma once

#include "kernels/model/sampler.h"
