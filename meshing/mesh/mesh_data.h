// A mesh and its fields as files hold them: plain arrays that the public interface shares.
#pragma once

#include "meshing/base/point.h"
#include "weft/data.h"
