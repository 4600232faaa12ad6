// What is thrown when the user's input cannot be used: InputError, which the public interface shares.
#pragma once

#include "weft/data.h"
