// Replaced by the branch that brings subdomains.
#include "partition/mesh_piece.h"
#include "partition/peers.h"
