// Parcels, and what is left behind.
#include "partition/shift/hand_over.h"

#include <algorithm>

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

/// What leaves for each receiver, ascending.
std::vector<std::vector<TetId>> leaving_to(const ReceiverOrder& order, const Chosen& chosen,
                                           std::span<const Receiver> receivers) {
  std::vector<std::size_t> tets_to(order.size(), 0);
  for (const TetId t : chosen.leaving) ++tets_to[chosen.to[t.value]];
  std::vector<std::vector<TetId>> leaving(receivers.size());
  std::vector<std::vector<TetId>*> of_place(order.size(), nullptr);
  for (Place r = 1; r < order.size(); ++r) {
    if (tets_to[r] == 0) continue;
    of_place[r] = &leaving[meshing::place_in(receivers, order.subdomain(r), &Receiver::id)];
    of_place[r]->reserve(tets_to[r]);
  }
  for (const TetId t : chosen.leaving) of_place[chosen.to[t.value]]->push_back(t);
  return leaving;
}

/// Where the tets around vertices have gone, to all who held them or have got some; to the latter also who
/// held them before.
void tell_holders(const Subdomain& s, std::span<const Departure> departures,
                  const std::vector<std::uint32_t>& interface_index, std::span<const Receiver> receivers,
                  std::span<Parcel> parcels) {
  const auto parcel_to = [&](SubdomainId to) -> Parcel& {
    return parcels[meshing::place_in(receivers, to, &Receiver::id)];
  };
  for (std::size_t i = 0; i < departures.size();) {
    const Departure& first = departures[i];
    std::size_t end = i;
    while (end < departures.size() && departures[end].id == first.id) ++end;
    const auto of_vertex = departures.subspan(i, end - i);
    i = end;
    const auto tell = [&](Parcel& parcel) {
      for (const Departure& d : of_vertex) parcel.now.push_back({d.id, d.to});
    };
    const std::uint32_t at = interface_index[first.vertex];
    const auto held_before = at == Interface::kNone ? std::span<const Holder>() : s.interface.others(at);
    for (const Holder& h : held_before) tell(parcel_to(h.subdomain));
    for (const Departure& d : of_vertex) {
      const bool held_it = std::ranges::find(held_before, d.to, &Holder::subdomain) != held_before.end();
      if (d.to == s.id || held_it) continue;
      Parcel& parcel = parcel_to(d.to);
      tell(parcel);
      if (held_before.empty()) continue;
      parcel.before.push_back({first.id, s.id});
      parcel.before.insert(parcel.before.end(), held_before.begin(), held_before.end());
    }
  }
}

/// The receivers' parcels, in their order.
std::vector<Parcel> pack(const Subdomain& s, const ReceiverOrder& order, const Chosen& chosen,
                         const Departures& departures, const std::vector<std::uint32_t>& interface_index,
                         std::span<const Receiver> receivers) {
  const std::vector<std::vector<TetId>> leaving = leaving_to(order, chosen, receivers);
  Packing::Places places(*s.mesh);
  std::vector<Parcel> parcels;
  for (std::size_t n = 0; n < receivers.size(); ++n)
    parcels.push_back(Packing(s, departures.is_of_interface, places).pack(chosen, leaving[n], receivers[n]));
  tell_holders(s, departures.of_interface, interface_index, receivers, parcels);
  return parcels;
}

}  // namespace

std::vector<Parcel> hand_over(Subdomain& s, const ReceiverOrder& order, const Chosen& chosen,
                              std::span<const Receiver> receivers) {
  const std::vector<std::uint32_t> index = interface_index(s);
  const Departures departures = find_departures(s, order, chosen, index);
  std::vector<Parcel> parcels = pack(s, order, chosen, departures, index, receivers);
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
