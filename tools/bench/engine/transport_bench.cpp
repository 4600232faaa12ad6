// Ping-pong of two ranks, bare MPI against MpiTransport in turns within one run; medians as JSON on standard
// output. mpirun -n 2 transport_bench
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <span>
#include <string>
#include <vector>

#include "engine/mpi/mpi_transport.h"
#include "tools/bench/engine/plain_mpi.h"

namespace weft::bench {
namespace {

using engine::Blob;
using engine::Packet;
using engine::Rank;

constexpr int kTurns = 15;

struct Case {
  std::size_t bytes;
  int rounds;
};
constexpr Case kHeads[] = {{8, 5000}, {1 << 10, 5000}, {16 << 10, 2000}};
constexpr Case kSegments[] = {{std::size_t{1} << 20, 50},
                              {std::size_t{16} << 20, 10},
                              {std::size_t{64} << 20, 4},
                              {std::size_t{256} << 20, 2}};

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// As a rank's loop does, but without sleeping.
Packet await_packet(engine::MpiTransport& transport) {
  Packet packet;
  bool arrived = false;
  while (!arrived) {
    transport.poll([&](Rank, std::span<const std::byte> head, std::vector<Blob> segments) {
      packet.head.assign(head.begin(), head.end());
      packet.segments = std::move(segments);
      arrived = true;
    });
  }
  return packet;
}

/// Rank 1 sends back what it gets, and rank 0 sends that again. `packet` is rank 0's first.
double round_trip(engine::MpiTransport& transport, Packet packet, int rounds) {
  const bool first = transport.rank() == Rank(0);
  const auto start = std::chrono::steady_clock::now();
  for (int round = 0; round < rounds; ++round) {
    if (first) transport.send(Rank(1), std::move(packet));
    packet = await_packet(transport);
    if (!first)
      transport.send(Rank(0), std::move(packet));  // a fresh one each round: NOLINT(bugprone-use-after-move)
  }
  while (transport.unsent(Rank(first ? 1 : 0)) > 0) transport.poll([](auto&&...) {});
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / rounds;
}

Packet first_packet(Rank rank, std::size_t bytes, bool as_head) {
  Packet packet;
  if (rank != Rank(0)) return packet;
  if (as_head) {
    packet.head.resize(bytes);
  } else {
    packet.segments.push_back(Blob::allocate(bytes));
    std::fill_n(packet.segments.back().data(), bytes, std::byte{1});
  }
  return packet;
}

struct Result {
  double plain, ours;  ///< seconds one way
};

Result measure(engine::MpiTransport& transport, const Case& test, bool as_head) {
  // The same kind of memory for both: large blobs lie on huge pages, which alone makes them faster to send.
  std::vector<Blob> buffers;
  for (int i = 0; i < 2; ++i) {
    buffers.push_back(Blob::allocate(test.bytes));
    std::fill_n(buffers.back().data(), test.bytes, std::byte{1});
  }
  const int rank = transport.rank().value;
  std::vector<double> plain, ours;
  for (int turn = -1; turn < kTurns; ++turn) {  // the first warms up
    const double p =
        plain_round_trip(rank, buffers[0].data(), buffers[1].data(), test.bytes, test.rounds) / 2;
    const double o =
        round_trip(transport, first_packet(transport.rank(), test.bytes, as_head), test.rounds) / 2;
    if (turn < 0) continue;
    plain.push_back(p);
    ours.push_back(o);
  }
  return {median(plain), median(ours)};
}

std::string latency_json(const Case& test, const Result& result) {
  char text[200];
  std::snprintf(
      text, sizeof text,
      R"(    {"bytes": %zu, "plain_us": %.3f, "transport_us": %.3f, "overhead_us": %.3f, "ratio": %.3f})",
      test.bytes, result.plain * 1e6, result.ours * 1e6, (result.ours - result.plain) * 1e6,
      result.ours / result.plain);
  return text;
}

std::string bandwidth_json(const Case& test, const Result& result) {
  const double gigabytes = static_cast<double>(test.bytes) * 1e-9;
  char text[200];
  std::snprintf(text, sizeof text,
                R"(    {"bytes": %zu, "plain_gb_s": %.3f, "transport_gb_s": %.3f, "ratio": %.3f})",
                test.bytes, gigabytes / result.plain, gigabytes / result.ours, result.plain / result.ours);
  return text;
}

template <class Json>
std::string list(engine::MpiTransport& transport, std::span<const Case> cases, bool as_heads,
                 const Json& json) {
  std::string text;
  for (const Case& test : cases) {
    if (!text.empty()) text += ",\n";
    text += json(test, measure(transport, test, as_heads));
  }
  return text;
}

void run(engine::MpiTransport& transport) {
  const auto latencies = list(transport, kHeads, true, latency_json);
  const auto bandwidths = list(transport, kSegments, false, bandwidth_json);
  if (transport.rank() != Rank(0)) return;
  std::printf("{\n  \"turns\": %d,\n  \"latency\": [\n%s\n  ],\n  \"bandwidth\": [\n%s\n  ]\n}\n", kTurns,
              latencies.c_str(), bandwidths.c_str());
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  try {
    weft::engine::MpiTransport transport(&argc, &argv);
    if (transport.size() != 2) {
      if (transport.rank() == weft::engine::Rank(0))
        std::fprintf(stderr, "transport_bench: runs on 2 ranks\n");
      transport.close();
      return EXIT_FAILURE;
    }
    weft::bench::run(transport);
    transport.close();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "transport_bench: %s\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
