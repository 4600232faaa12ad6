// Why an operator did or did not act: verdicts and their counts, which the public interface shares.
#pragma once

#include "weft/data.h"
