// Parcels, and what is left behind.
#include "partition/shift/hand_over.h"

#include "meshing/base/place_in.h"
#include "partition/shift/departures.h"
#include "partition/shift/packing.h"

namespace weft::partition {

using meshing::TetId;
using meshing::VertexId;

namespace {

/// Index in the interface of each vertex by slot, kNone for others.
std::vector<std::uint32_t> interface_index(const Subdomain& s) {
  std::vector<std::uint32_t> index(s.mesh->vertex_slots(), Interface::kNone);
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) index[s.interface.local(i).value] = i;
  return index;
}

/// The receivers' parcels, in their order.
std::vector<Parcel> pack(const Subdomain& s, const ReceiverOrder& order, const Chosen& chosen,
                         const std::vector<Departure>& departures,
                         const std::vector<std::uint32_t>& interface_index,
                         std::span<const Receiver> receivers) {
  std::vector<std::uint32_t> place_of_tet(chosen.to.size());
  std::vector<Packing> packing;
  packing.reserve(receivers.size());
  for (const Receiver& receiver : receivers)
    packing.emplace_back(s, receiver.id, interface_index, place_of_tet);
  std::vector<std::size_t> tets_to(order.size(), 0);
  for (const TetId t : chosen.leaving) ++tets_to[chosen.to[t.value]];
  std::vector<Packing*> packing_of(order.size(), nullptr);
  for (Place r = 1; r < order.size(); ++r) {
    if (tets_to[r] == 0) continue;
    packing_of[r] = &packing[meshing::place_in(receivers, order.subdomain(r), &Receiver::id)];
    packing_of[r]->reserve(tets_to[r]);
  }
  constexpr std::size_t kAhead = 12;  // tets: their vertices were last used when the subdomain was adapted
  for (std::size_t i = 0; i < chosen.leaving.size(); ++i) {
    if (i + kAhead < chosen.leaving.size())
      for (const VertexId v : s.mesh->vertices(chosen.leaving[i + kAhead])) s.mesh->prefetch(v);
    packing_of[chosen.to[chosen.leaving[i].value]]->add(chosen.leaving[i]);
  }
  std::vector<Parcel> parcels;
  for (std::size_t n = 0; n < packing.size(); ++n)
    parcels.push_back(packing[n].finish(chosen, departures, receivers[n]));
  return parcels;
}

}  // namespace

std::vector<Parcel> hand_over(Subdomain& s, const ReceiverOrder& order, const Chosen& chosen,
                              std::span<const Receiver> receivers) {
  const std::vector<std::uint32_t> index = interface_index(s);
  const Departures departures = find_departures(s, order, chosen, index);
  std::vector<Parcel> parcels = pack(s, order, chosen, departures.of_interface, index, receivers);
  for (const Departure& d : departures.of_interface) {
    s.departures.push_back({d.id, d.to});
    const VertexId v(d.vertex);
    if (!s.frozen_since.empty() && s.frozen_since.back() == v) continue;  // goes to several
    s.mesh->freeze(v);
    s.frozen_since.push_back(v);
  }
  remove_leaving(s, chosen, departures);
  return parcels;
}

}  // namespace weft::partition
