// <meander/sample_parameters.h>: everything that decides the samples of a model. See SampleParameters.
#pragma once

#include "kernels/model/sample_parameters.h"
