// The interface shift as messages between neighbours: proposals, parcels of tets, notices of who holds what.
// Plain functions on one subdomain; who calls them when, and how the messages travel, is not known here.
//
//   propose()          every subdomain tells its neighbours its priority and which vertices are to be freed
//   gather()           the holder of highest priority receives all tets around such a vertex and some layers
//                      more; each tet goes to one subdomain
//   scatter()          what arrived is joined by global ids; the interface is where others' tets begin now
//   update_topology()  those who have come to hold a vertex learn of all others who do
//
// For each interface vertex the holder of the highest priority receives. A subdomain above all its neighbours
// receives everything, as in Luby's algorithm; but the others, which would be idle, also receive from those
// below them. So one round frees all of the interface but for the tets where three subdomains meet, instead
// of that of a third of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "partition/shift/colouring.h"
#include "partition/subdomain/subdomain.h"

namespace weft::partition {

/// First message of a round to each neighbour.
struct Proposal {
  Priority priority;
  std::vector<GlobalId> wants;  ///< shared with the neighbour, to be freed; ascending
  /// Ids of the background pieces that the sender has, which need not be sent to it; ascending.
  std::vector<std::uint64_t> pieces;
  std::vector<std::uint32_t> surface;  ///< of its surface pieces, likewise

  template <class Archive>
  void serialize(Archive& archive) {
    archive(priority, wants, pieces, surface);
  }
};

/// Tets that change subdomains with all that belongs to them, and what the receiver must know about other
/// tets that left the sender.
struct Parcel {
  struct Vertex {
    GlobalId id;
    meshing::Point point;
    meshing::LogMetric log_metric;
    BackgroundTet background;
    std::uint32_t surface_hint;
    std::int32_t ref;
    meshing::VertexKind kind;
    std::uint8_t flags;
    bool shared;  ///< others may have it: it is of the sender's interface, or is so from now on
  };
  struct Tet {
    std::array<std::uint32_t, 4> vertices;  ///< in the parcel
    std::array<std::uint32_t, 4>
        neighbours;  ///< in the parcel, as meshing::Adjacency; kNoNeighbour elsewhere
    std::int32_t ref;
    float quality;  ///< the kernel's cached one
  };
  struct BoundaryFace {
    std::uint32_t face;  ///< 4 * tet in the parcel + its face
    meshing::PatchId patch;
  };
  struct FeatureEdge {
    std::array<std::uint32_t, 2> ends;  ///< in the parcel
    meshing::CurveId curve;
  };
  SubdomainId from;
  std::vector<Vertex> vertices;
  std::vector<Tet> tets;
  std::vector<BoundaryFace> boundary_faces;
  std::vector<FeatureEdge> feature_edges;
  /// Background pieces that the receiver lacks; immutable, so shared within a rank.
  std::vector<std::shared_ptr<const BackgroundPiece>> pieces;
  std::vector<meshing::SurfacePieces::Piece> surface;  ///< likewise
  /// Where the sender's tets around a vertex are now, for vertices of the parcel and those shared with the
  /// receiver. Left out where all of them stay with the sender, and where all go to the receiver and no
  /// other subdomain had any.
  std::vector<Holder> now;
  /// Former holders of vertices of the parcel that the receiver did not hold.
  std::vector<Holder> before;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(from, vertices, tets, boundary_faces, feature_edges, now, before);
    serialize_pieces(archive, pieces);
    meshing::serialize_pieces(archive, surface);
  }
};

/// All holders of vertices that the addressee has come to hold.
struct Notice {
  std::vector<Holder> holders;  ///< sorted

  template <class Archive>
  void serialize(Archive& archive) {
    archive(holders);
  }
};

/// Of the neighbours, in their order.
std::vector<Priority> priorities_of(std::span<const Proposal> proposals);

struct ShiftOptions {
  int layers = 2;         ///< of tets, point-connected, handed over beyond those at the interface
  bool by_faces = false;  ///< layers grow through faces instead of points
  /// The first shift hands over `layers` and moves the interface away; later ones free what is left, mostly
  /// where three subdomains meet, for which one layer is enough. False: all shifts hand over `layers`.
  bool fewer_later = true;

  ShiftOptions in_round(std::uint64_t round) const {
    return {round == 0 || !fewer_later ? layers : std::min(layers, 1), by_faces, fewer_later};
  }
};

/// The interface vertices that this subdomain wants to be freed, ascending: those that have never been free
/// and, in the first kRoundsForQuality rounds, those of poor tets and of tets that touch them. (Some poor
/// tets cannot be improved by any shift.)
inline constexpr std::uint64_t kRoundsForQuality = 10;
std::vector<GlobalId> wanted(const Subdomain& subdomain, std::uint64_t round);

/// One proposal for each of the interface's neighbours, in their order.
std::vector<Proposal> propose(const Subdomain& subdomain, const Priority& mine,
                              std::span<const GlobalId> wanted);

/// How many of the vertices that it or a neighbour wants to be freed this subdomain receives the tets around;
/// at none it receives nothing in this round. `proposals`: as for gather(), before which this is called.
std::size_t vertices_received(const Subdomain& subdomain, const ReceiverOrder& order,
                              std::span<const GlobalId> wanted, std::span<const Proposal> proposals);

/// Removes the tets that leave from the mesh. `proposals` are those of the neighbours, in their order; so
/// are the parcels, many of them empty.
std::vector<Parcel> gather(Subdomain& subdomain, const Priority& mine, std::span<const GlobalId> wanted,
                           std::span<const Proposal> proposals, const ShiftOptions& options);

/// Result of scatter(): notices to send and to expect.
struct Scattered {
  std::uint64_t received = 0;  ///< tets
  std::uint64_t thawed = 0;    ///< former interface vertices
  struct Addressed {
    SubdomainId to;
    Notice notice;
  };
  std::vector<Addressed> notices;     ///< by addressee, ascending
  std::vector<SubdomainId> expected;  ///< senders of notices to this subdomain, ascending
};

/// Joins the parcels of all neighbours, in the order of the neighbours, with the mesh. Tets around thawed
/// vertices get the mark kFresh: all others have been adapted already.
Scattered scatter(Subdomain& subdomain, std::span<Parcel> parcels);

/// Takes the notices of all expected senders. Returns the number of former interface vertices it finds.
std::uint64_t update_topology(Subdomain& subdomain, std::span<const Notice> notices);

}  // namespace weft::partition
