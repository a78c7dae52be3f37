// <meander/row.h>: the result of sampling a model: samples, descriptors and the report of the item. See Row.
#pragma once

#include "kernels/data/samples.h"
