#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "io/image/png_reader.h"
#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "io/table/npy_header.h"
#include "io/xml_reader.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/store_rows.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

ProcessResult retrieve(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "retrieve");
  return meander_with(std::move(arguments));
}

// Cells of the line of a CSV file that begins with this cell.
std::vector<std::string> csv_line(const std::filesystem::path& path, const std::string& first) {
  std::istringstream lines(read_file(path));
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::vector<std::string> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    if (!row.empty() && row[0] == first) return row;
  }
  return {};
}

// Rows on a line: the descriptor `place` is (x, 0, 0, 0), `flat` is the same for all, `wide` is 10 x.
struct Item {
  std::string id;
  std::int32_t label;
  float x;
  Status status = Status::ok;
};
// Class 0 lies around 0, class 1 around 10 but for one outlier, class 2 has two rows, class 3 one.
const std::vector<Item> items = {
    {"db/0/m10/m10.off", 0, 0.0f},  {"db/0/m11/m11.off", 0, 0.1f},
    {"db/0/m12/m12.off", 0, 0.3f},  {"db/0/m13/m13.off", 1, 10},
    {"db/0/m14/m14.off", 1, 10.1f}, {"db/0/m15/m15.off", 1, 0.7f},
    {"db/0/m16/m16.off", 2, 20},    {"db/0/m17/m17.off", 2, 21},
    {"db/0/m18/m18.off", 3, 30},    {"db/0/m19/m19.off", 0, 0, Status::unreadable},
    {"db/0/m20/m20.off", -1, 0.05f}};

struct Written {
  std::vector<Item> rows = items;
  std::vector<std::string> label_names = {"ant", "bee", "cat", "dog"};
  bool with_descriptors = true, with_labels = true, with_gap = false, with_bins = false;
};

void write_items(const std::filesystem::path& store, const Written& written) {
  const auto& [rows, label_names, with_descriptors, with_labels, with_gap, with_bins] = written;
  StoreHeader header;
  header.samples = 1;
  header.parameters_json = "{}";
  header.label_names = label_names;
  if (with_descriptors) header.descriptors = {{"place", 4, {}}, {"flat", 3, {}}, {"wide", 1, {}}};
  if (with_bins) header.descriptors[1].attributes = header.descriptors[2].attributes = {{"bins", "some"}};
  header.descriptors.push_back({"error", 1, {}, "certificate"});
  for (const Item& item : rows) {
    header.ids.push_back(item.id);
    header.labels.push_back(with_labels ? item.label : -1);
  }
  RunDirectory run(store, header);
  for (std::uint64_t i = 0; i < rows.size(); ++i) {
    Row row;
    if (rows[i].status == Status::ok) {
      row = row_of_one_sample();
      const float x = rows[i].x;
      const float wide = with_gap && i == 3 ? std::numeric_limits<float>::infinity() : 10 * x;
      if (with_descriptors)
        row.descriptors = {{"place", {x, 0, 0, 0}}, {"flat", {1, 2, 3}}, {"wide", {wide}}};
      row.descriptors.push_back({"error", {1}});
    } else {
      row.report.status = rows[i].status;
      row.report.reason = "made so";
    }
    run.begin_item(i);
    run.end_item(encode_row(header, i, row));
  }
  run.finish();
}

void write_items(const std::filesystem::path& store, bool with_descriptors = true, bool with_labels = true,
                 bool with_gap = false, bool with_bins = false) {
  write_items(store, {.with_descriptors = with_descriptors,
                      .with_labels = with_labels,
                      .with_gap = with_gap,
                      .with_bins = with_bins});
}

}  // namespace

TEST_CASE("read_descriptor: reads all rows, with NaN where a row is not ok") {
  const ScratchFolder scratch;
  write_items(scratch / "s.h5");
  const StoreReader store(scratch / "s.h5");
  const std::vector<float> values = store.read_descriptor("place");
  REQUIRE(values.size() == 4 * items.size());
  for (std::size_t i = 0; i < items.size(); ++i)
    if (items[i].status == Status::ok)
      CHECK(std::vector<float>(values.begin() + static_cast<std::ptrdiff_t>(4 * i),
                               values.begin() + static_cast<std::ptrdiff_t>(4 * i + 4)) ==
            std::vector<float>{items[i].x, 0, 0, 0});
    else
      CHECK(std::isnan(values[4 * i]));
  CHECK(store.read_descriptor("error")[0] == 1);
  CHECK_THROWS_AS(store.read_descriptor("plaice"), RunError);
}

TEST_CASE("retrieve query: gives the nearest models, without the query and rows that are not ok") {
  const ScratchFolder scratch;
  write_items(scratch / "s.h5");
  const ProcessResult result =
      retrieve({"query", scratch / "s.h5", "db/0/m10/m10.off", "-k", "3", "--csv", scratch / "q.csv"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(csv_line(scratch / "q.csv", "1")[2] == "db/0/m20/m20.off");
  CHECK(csv_line(scratch / "q.csv", "1")[3].empty());  // no class
  CHECK(csv_line(scratch / "q.csv", "2")[2] == "db/0/m11/m11.off");
  CHECK(csv_line(scratch / "q.csv", "3")[2] == "db/0/m12/m12.off");
  CHECK(csv_line(scratch / "q.csv", "3")[3] == "ant");
  CHECK(std::stod(csv_line(scratch / "q.csv", "3")[4]) == Approx(0.3));
  CHECK(csv_line(scratch / "q.csv", "4").empty());
  // By row number, as JSON; ties by row.
  const ProcessResult json =
      retrieve({"query", scratch / "s.h5", "4", "-k", "2", "--descriptor", "flat", "--json"});
  REQUIRE(json.exit_code == 0);
  CHECK(contains(json.out, R"("item":"db/0/m14/m14.off")"));
  CHECK(contains(json.out, R"("not_ok":1)"));
  CHECK(contains(json.out, R"("id":"db/0/m10/m10.off")"));
  CHECK(contains(json.out, R"("id":"db/0/m11/m11.off")"));
  CHECK_FALSE(contains(json.out, R"("id":"db/0/m12/m12.off")"));
}

TEST_CASE("retrieve evaluate: scores match hand calculations, with omitted rows and tiny classes") {
  const ScratchFolder scratch;
  write_items(scratch / "s.h5");
  const ProcessResult result =
      retrieve({"evaluate", scratch / "s.h5", "--per-class", "--csv", scratch / "e.csv"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.out, "9 models, 8 queries of 3 classes; descriptor place, distance l1"));
  CHECK(contains(result.out, "left out: 1 not ok, 1 without a class"));
  // Nearest: all of ant right; of bee the outlier finds ant; both cats right.
  CHECK(std::stod(csv_line(scratch / "e.csv", "(micro)")[2]) == Approx(7.0 / 8));
  CHECK(std::stod(csv_line(scratch / "e.csv", "(macro)")[2]) == Approx((1 + 2.0 / 3 + 1) / 3));
  CHECK(std::stod(csv_line(scratch / "e.csv", "bee")[2]) == Approx(2.0 / 3));
  CHECK(std::stod(csv_line(scratch / "e.csv", "ant")[3]) == 1);
  // First tier of bee: m13 finds m14, then m15 (9.3 away, ants 9.7); m14 the same; the outlier none.
  CHECK(std::stod(csv_line(scratch / "e.csv", "bee")[3]) == Approx(2.0 / 3));
  CHECK(csv_line(scratch / "e.csv", "dog")[1] == "1");  // counted, not scored
  CHECK(csv_line(scratch / "e.csv", "dog")[2].empty());

  const ProcessResult psb = retrieve({"evaluate", scratch / "s.h5", "--psb-compat", "--json"});
  REQUIRE(psb.exit_code == 0);
  CHECK(contains(psb.out, R"("queries":6,"classes":2)"));
  CHECK(contains(psb.out, "as psbTable"));

  // Without any information every rank is random: NN of a class of 3 among 8 is 2/8.
  const ProcessResult flat = retrieve(
      {"evaluate", scratch / "s.h5", "--descriptor", "flat", "--per-class", "--csv", scratch / "f.csv"});
  REQUIRE(flat.exit_code == 0);
  CHECK(std::stod(csv_line(scratch / "f.csv", "ant")[2]) == Approx(0.25));
  CHECK(std::stod(csv_line(scratch / "f.csv", "cat")[3]) == Approx(0.125));
}

TEST_CASE("retrieve evaluate: ranges of the queries, merged, score as all at once") {
  const ScratchFolder scratch;
  const std::string store = scratch / "s.h5";
  write_items(store);
  const std::vector<std::string> setting = {"evaluate", store, "--descriptor", "place+flat"};
  const auto evaluate = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = setting;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return retrieve(arguments);
  };
  const std::string whole = evaluate({"--json"}).out;
  REQUIRE(contains(whole, "precision_micro"));
  for (const int shards : {1, 3, 20}) {  // of nine queries
    std::vector<std::string> reading = {"--json", "--read-scores"};
    for (int i = 0; i < shards; ++i) {
      const std::string file = scratch / ("part" + std::to_string(i));
      const ProcessResult part =
          evaluate({"--shard", std::to_string(i) + "/" + std::to_string(shards), "--write-scores", file});
      INFO(part.err);
      REQUIRE(part.exit_code == 0);
      reading.push_back(file);
    }
    const ProcessResult all = evaluate(reading);
    INFO(all.err);
    CHECK(all.out == whole);
  }
  const auto fails = [&](const std::vector<std::string>& more, const char* why) {
    const ProcessResult result = evaluate(more);
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, why));
  };
  REQUIRE(evaluate({"--shard", "0/2", "--write-scores", scratch / "a"}).exit_code == 0);
  REQUIRE(evaluate({"--shard", "1/2", "--write-scores", scratch / "b"}).exit_code == 0);
  fails({"--read-scores", scratch / "a"}, "5 of 9 queries are missing from the files");
  fails({"--read-scores", scratch / "a", scratch / "a", scratch / "b"}, "is in an earlier file");
  fails({"--distance", "l2", "--read-scores", scratch / "a", scratch / "b"},
        "distance, classes or rules differ");
  const std::string bytes = read_file(scratch / "b");
  for (const std::size_t at : {std::size_t{3}, bytes.size() / 2, bytes.size() - 1}) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    write_file(scratch / "b", damaged);
    fails({"--read-scores", scratch / "a", scratch / "b"}, "is not a file of scores");
  }
  write_file(scratch / "b", bytes.substr(0, 20));
  fails({"--read-scores", scratch / "a", scratch / "b"}, "is not a file of scores");
  fails({"--shard", "0/2"}, "go together");
  fails({"--write-scores", scratch / "c"}, "go together");
  fails({"--shard", "0/2", "--write-scores", store}, "the store itself");
  fails({"--shard", "0/2", "--write-scores", scratch / "c", "--matrix", scratch / "m"},
        "scores of all queries");
  fails({"--read-scores", scratch / "a", "--matrix", scratch / "m"}, "needs all distances");
}

TEST_CASE("retrieve evaluate: combined descriptors, non-finite rows and every distance") {
  const ScratchFolder scratch;
  write_items(scratch / "s.h5", true, true, true);
  for (const std::string distance : {"l1", "l2", "emd", "chi2", "cosine"}) {
    const ProcessResult result = retrieve(
        {"evaluate", scratch / "s.h5", "--descriptor", "place+wide", "--distance", distance, "--json"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    CHECK(contains(result.out, R"("descriptor":"place+wide","distance":")" + distance + "\""));
    CHECK(contains(result.out, R"("not_finite":1)"));
    CHECK(contains(result.out, R"("models":8)"));
  }
  // wide is ten times place: combined they order as either does.
  write_items(scratch / "t.h5");
  const auto scores = [&](const std::string& descriptor) {
    REQUIRE(retrieve({"evaluate", scratch / "t.h5", "--descriptor", descriptor, "--csv", scratch / "c.csv"})
                .exit_code == 0);
    return csv_line(scratch / "c.csv", "(micro)");
  };
  CHECK(scores("place+wide") == scores("place"));
}

TEST_CASE("retrieve --rank: evaluate says what it used, and query lists what evaluate scores") {
  const ScratchFolder scratch;
  const std::string store = scratch / "s.h5";
  Written written;
  written.rows.clear();
  for (int i = 0; i < 40; ++i) {  // ants lie dense, bees far apart
    const std::string id = "m" + std::to_string(100 + i) + ".off";
    written.rows.push_back(
        {id, i < 20 ? 0 : 1,
         i < 20 ? 0.1f * static_cast<float>(i * i % 37) : 3.5f * static_cast<float>(i - 18)});
  }
  write_items(store, written);
  const auto evaluate = [&](const std::string& rank, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"evaluate", store, "--rank", rank};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return retrieve(arguments);
  };
  CHECK(evaluate("plain", {"--json"}).out == retrieve({"evaluate", store, "--json"}).out);
  CHECK(contains(evaluate("scaled").out, "descriptor place, distance l1, rank scaled\n"));
  CHECK(contains(evaluate("diffusion:4,0.5", {"--json"}).out, R"("rank":"diffusion:4,0.5")"));
  // 40 rows: log2 - 2.
  CHECK(contains(evaluate("diffusion").out, "distance l1, rank diffusion:3,0.85 of weight 0.5, "));
  for (const std::string rank : {"plain", "scaled", "diffusion", "diffusion:5,0.9"}) {
    INFO(rank);
    REQUIRE(evaluate(rank, {"--matrix", scratch / "m.bin"}).exit_code == 0);
    const std::string bytes = read_file(scratch / "m.bin");
    std::vector<float> row(40);
    std::memcpy(row.data(), bytes.data() + 4 * 40 * 21, 4 * 40);
    CHECK(row[21] == 0);
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < 40; ++i)
      if (i != 21) order.push_back(i);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return row[a] < row[b]; });
    REQUIRE(retrieve({"query", store, "m121.off", "-k", "6", "--rank", rank, "--csv", scratch / "q.csv"})
                .exit_code == 0);
    for (std::size_t i = 0; i < 6; ++i) {
      const auto line = csv_line(scratch / "q.csv", std::to_string(i + 1));
      CHECK(line[1] == std::to_string(order[i]));
      CHECK(std::stod(line[4]) == Approx(static_cast<double>(row[order[i]])));
    }
  }
  // Parts of an evaluation, and parts of another ranking.
  for (const std::string part : {"0/2", "1/2"})
    REQUIRE(evaluate("diffusion", {"--shard", part, "--write-scores", scratch / ("p" + part.substr(0, 1))})
                .exit_code == 0);
  const std::vector<std::string> parts = {"--json", "--read-scores", scratch / "p0", scratch / "p1"};
  CHECK(evaluate("diffusion", parts).out == evaluate("diffusion", {"--json"}).out);
  CHECK(evaluate("scaled", parts).exit_code == 2);
  for (const std::string wrong : {"best", "diffusion:", "diffusion:3", "diffusion:0,0.5", "diffusion:65,0.5",
                                  "diffusion:4,1", "diffusion:4,x", "scaled:3"}) {
    const ProcessResult refused = evaluate(wrong);
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, "--rank: `" + wrong + "` is not plain, scaled, diffusion or"));
  }
  // A graph made once gives the same answers; one that does not fit is made anew, and a damaged one refused.
  const std::string whole = evaluate("diffusion", {"--json"}).out;
  const ProcessResult graph = retrieve({"graph", store, "--descriptor", "place"});
  INFO(graph.err);
  REQUIRE(graph.exit_code == 0);
  CHECK(contains(graph.out, "s.h5.graph: 40 models, "));
  CHECK(evaluate("diffusion", {"--json"}).out == whole);
  CHECK(evaluate("diffusion", {"--json", "--descriptor", "flat"}).exit_code == 0);
  const std::string graph_bytes = read_file(store + ".graph");
  REQUIRE(retrieve({"graph", store, "--descriptor", "place"}).exit_code == 0);
  CHECK(read_file(store + ".graph") == graph_bytes);
  CHECK(contains(retrieve({"graph", store, "--rank", "scaled"}).err, "--rank: `scaled` needs no graph"));
  for (const std::size_t at : {std::size_t{2}, graph_bytes.size() / 2, graph_bytes.size() - 1}) {
    std::string damaged = graph_bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 8);
    write_file(store + ".graph", damaged);
    const ProcessResult refused = evaluate("diffusion");
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, "s.h5.graph` is not a graph that this program can use"));
  }
  write_file(store + ".graph", graph_bytes);
  const ProcessResult large = evaluate("diffusion", {"--memory", "50M"});
  CHECK(large.exit_code == 2);
  CHECK(contains(large.err, "--memory: a comparison of 40 models needs about"));
}

TEST_CASE("retrieve evaluate: the matrix and the classes of a .cla file, in its order") {
  const ScratchFolder scratch;
  write_items(scratch / "s.h5");
  write_file(scratch / "x.cla",
             "PSB 1\n3 8\n\nfar 0 3\n18\n17\n16\n\ninsect 0 0\n\nnear insect 5\n13 14 m15\n10 999\n");
  const ProcessResult result =
      retrieve({"evaluate", scratch / "s.h5", "--classes", scratch / "x.cla", "--matrix", scratch / "m.bin",
                "--per-class", "--csv", scratch / "e.csv"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.out, "7 models, 7 queries of 2 classes"));
  CHECK(contains(result.out, "4 without a class, 1 of the .cla that the store does not have"));
  CHECK(csv_line(scratch / "e.csv", "far")[1] == "3");
  CHECK(csv_line(scratch / "e.csv", "insect").empty());
  const std::string bytes = read_file(scratch / "m.bin");
  const std::vector<float> at{30, 21, 20, 10, 10.1f, 0.7f, 0};
  REQUIRE(bytes.size() == 4 * at.size() * at.size());
  for (std::size_t i = 0; i < at.size(); ++i)
    for (std::size_t j = 0; j < at.size(); ++j) {
      float value;
      std::memcpy(&value, bytes.data() + 4 * (i * at.size() + j), 4);
      CHECK(value == std::abs(at[i] - at[j]));
    }
  std::istringstream ids(read_file(scratch / "m.bin.ids.csv"));
  std::string line;
  REQUIRE(std::getline(ids, line));
  CHECK(line == "position,row,id,label");
  for (std::size_t i = 0; i < at.size(); ++i) {
    REQUIRE(std::getline(ids, line));
    CHECK(line.starts_with(std::to_string(i) + ","));
    CHECK(line.ends_with(i < 3 ? ",far" : ",near"));
  }
  CHECK_FALSE(std::getline(ids, line));
  // psbTable leaves the miscellaneous class out of the averages.
  write_file(scratch / "y.cla", "PSB 1\n2 6\nmiscellaneous 0 3\n16 17 18\nnear 0 3\n10 11 12\n");
  const ProcessResult psb =
      retrieve({"evaluate", scratch / "s.h5", "--classes", scratch / "y.cla", "--psb-compat"});
  REQUIRE(psb.exit_code == 0);
  CHECK(contains(psb.out, "6 models, 3 queries of 1 classes"));
}

TEST_CASE("retrieve select: settings score as in evaluate, and are chosen by the other classes") {
  const ScratchFolder scratch;
  write_items(scratch / "s.h5");
  const ProcessResult result = retrieve({"select", scratch / "s.h5", "--descriptors", "flat,place,place+wide",
                                         "--distances", "l1,chi2", "--csv", scratch / "all.csv"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.out, "9 models, 8 queries of 3 classes; 6 settings"));
  CHECK(contains(result.out, "left out: 1 not ok, 1 without a class"));
  CHECK(contains(result.out, "leaving one class out"));
  std::istringstream lines(read_file(scratch / "all.csv"));
  std::string line;
  std::getline(lines, line);
  CHECK(line == "descriptor,distance,NN,1st tier,2nd tier,E-measure,DCG,mAP,criterion,classes");
  std::size_t settings = 0, chosen = 0;
  double before = 2;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::istringstream split(line);
    for (std::string cell; std::getline(split, cell, ',');) cells.push_back(cell);
    REQUIRE(cells.size() == 10);
    REQUIRE(retrieve({"evaluate", scratch / "s.h5", "--descriptor", cells[0], "--distance", cells[1], "--csv",
                      scratch / "e.csv"})
                .exit_code == 0);
    const std::vector<std::string> scores = csv_line(scratch / "e.csv", "(micro)");
    CHECK(std::vector<std::string>(cells.begin() + 2, cells.begin() + 8) ==
          std::vector<std::string>(scores.begin() + 2, scores.begin() + 8));
    const double criterion = std::stod(cells[8]);
    CHECK(criterion == Approx((std::stod(cells[2]) + std::stod(cells[3])) / 2));
    CHECK(criterion <= before);
    before = criterion;
    chosen += std::stoul(cells[9]);
    ++settings;
  }
  CHECK(settings == 6);
  CHECK(chosen == 3);

  // One setting to choose from: the scores of `evaluate`.
  const ProcessResult lone = retrieve({"select", scratch / "s.h5", "--descriptors", "place", "--distances",
                                       "l1", "--criterion", "map", "--json"});
  REQUIRE(lone.exit_code == 0);
  CHECK(contains(lone.out, R"("criterion":"map")"));
  CHECK(
      contains(lone.out, R"x({"class":"(micro)","models":8,"descriptor":null,"distance":null,"NN":0.875,)x"));
  CHECK(contains(lone.out, R"({"class":"cat","models":2,"descriptor":"place","distance":"l1","NN":1,)"));

  // All sets of up to two histograms; `place` is none, as it does not say its bins.
  write_items(scratch / "h.h5", true, true, false, true);
  const ProcessResult sets =
      retrieve({"select", scratch / "h.h5", "--most", "2", "--distances", "l2", "--json"});
  INFO(sets.err);
  REQUIRE(sets.exit_code == 0);
  for (const std::string name : {"flat", "wide", "flat+wide"})
    CHECK(contains(sets.out, R"("descriptor":")" + name + R"(","distance":"l2")"));
  CHECK_FALSE(contains(sets.out, "place"));

  const auto refusal = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"select", scratch / "s.h5"});
    const ProcessResult refused = retrieve(arguments);
    CHECK(refused.exit_code == 2);
    return refused.err;
  };
  CHECK(contains(refusal({}), "no histogram descriptors"));
  CHECK(contains(refusal({"--descriptors", "place,wid"}), "did you mean `wide`?"));
  CHECK(contains(refusal({"--descriptors", "place", "--most", "2"}), "--descriptors"));
  CHECK(contains(refusal({"--descriptors", "place", "--distances", "l3"}), "l3"));
  write_file(scratch / "one.cla", "PSB 1\n2 4\nnear 0 3\n10 11 12\nfar 0 1\n16\n");
  CHECK(contains(refusal({"--descriptors", "place", "--classes", scratch / "one.cla"}),
                 "leaving one class out needs two"));
}

TEST_CASE("retrieve evaluate: classes of the same name under two parents are distinct") {
  const ScratchFolder scratch;
  write_items(scratch / "s.h5");
  write_file(scratch / "twins.cla",
             "PSB 1\n5 7\n\nanimal 0 0\n\nplant 0 0\n\nfly animal 3\n10\n11\n12\n\nfly plant 2\n13\n14\n\n"
             "tree plant 2\n16\n17\n");
  const ProcessResult result = retrieve({"evaluate", scratch / "s.h5", "--classes", scratch / "twins.cla",
                                         "--per-class", "--csv", scratch / "e.csv"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.out, "7 models, 7 queries of 3 classes"));
  CHECK(csv_line(scratch / "e.csv", "animal/fly")[1] == "3");
  CHECK(csv_line(scratch / "e.csv", "plant/fly")[1] == "2");
  CHECK(csv_line(scratch / "e.csv", "tree")[1] == "2");  // alone of its name: without its parent
  CHECK(csv_line(scratch / "e.csv", "fly").empty());
}

TEST_CASE("retrieve evaluate --html: one self-contained page, whatever the ids and classes") {
  const ScratchFolder scratch;
  std::vector<Item> hostile = items;
  hostile[0].id = "db/0/a<script>alert('1')</script>.off";
  hostile[4].id = "db/0/m14&\"quoted\"_{low}.off";
  hostile[5].id = "db/0/m15<img src=x onerror=alert(1)>.off";  // the outlier: a confusion
  std::sort(hostile.begin(), hostile.end(), [](const Item& a, const Item& b) { return a.id < b.id; });
  write_items(scratch / "s.h5", {.rows = hostile, .label_names = {"ant", "<b>bee</b>", "cat", "dog"}});
  const ProcessResult result = retrieve({"evaluate", scratch / "s.h5", "--html", scratch / "page.html"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string page = read_file(scratch / "page.html");
  const auto elements = XmlReader::read(page);  // well-formed
  CHECK(named(elements, "script").empty());
  CHECK(named(elements, "img").empty());
  CHECK(named(elements, "b").empty());
  for (const auto& element : elements)
    for (const auto& [name, value] : element.attributes) {
      INFO(element.name << " " << name << "=" << value);
      CHECK((name != "src" && !name.starts_with("on")));
      if (name == "href") CHECK(value.starts_with("#"));
    }
  CHECK(named(elements, "svg").size() == 2);
  std::vector<std::string> cells;
  for (const auto& cell : named(elements, "td")) cells.push_back(cell.text);
  const auto at = std::find(cells.begin(), cells.end(), "db/0/m15<img src=x onerror=alert(1)>.off");
  REQUIRE(cells.end() - at >= 8);
  CHECK(at[1] == "<b>bee</b>");
  CHECK(at[2] == "db/0/m12/m12.off");
  CHECK(at[3] == "ant");
  CHECK(at[4] == "0.4000");
  CHECK(at[5] == "db/0/m13/m13.off");
  CHECK(at[6] == "9.300");
  // Every descriptor of the store on its own.
  for (const char* name : {"place", "flat", "wide"})
    CHECK(std::find(cells.begin(), cells.end(), name) != cells.end());
  CHECK(contains(page, "NaN") == false);
  const ProcessResult again = retrieve(
      {"evaluate", scratch / "s.h5", "--html", scratch / "again.html", "--descriptor", "wide+place"});
  REQUIRE(again.exit_code == 0);
  CHECK(contains(read_file(scratch / "again.html"), "wide+place"));
  // So are vectors beside it.
  const std::vector<float> vectors = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  const std::uint64_t shape[] = {vectors.size(), 1};
  write_file(scratch / "net.npy",
             npy_header("<f4", shape) + std::string(reinterpret_cast<const char*>(vectors.data()), 44));
  REQUIRE(retrieve({"evaluate", scratch / "s.h5", "--html", scratch / "net.html", "--descriptor", "net+place",
                    "--vectors", scratch / "net.npy"})
              .exit_code == 0);
  const auto settings = named(XmlReader::read(read_file(scratch / "net.html")), "td");
  for (const char* name : {"net+place", "place", "flat", "wide", "net"})
    CHECK(std::count_if(settings.begin(), settings.end(),
                        [&](const auto& cell) { return cell.text == name; }) == 1);
  write_file(scratch / "notes.txt", "mine");
  CHECK(retrieve({"evaluate", scratch / "s.h5", "--html", scratch / "notes.txt"}).exit_code == 2);
  CHECK(read_file(scratch / "notes.txt") == "mine");
}

TEST_CASE("retrieve evaluate: pictures are drawn") {
  const ScratchFolder scratch;
  write_items(scratch / "s.h5");
  const ProcessResult result = retrieve({"evaluate", scratch / "s.h5", "--per-class", "--picture",
                                         scratch / "pr.svg", "--confusion", scratch / "c.svg"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(read_file(scratch / "pr.svg"), "mean over queries"));
  CHECK(contains(read_file(scratch / "pr.svg"), ">cat<"));
  const std::string confusion = read_file(scratch / "c.svg");
  CHECK(contains(confusion, ">67<"));  // two of three bees find a bee
  CHECK(contains(confusion, ">33<"));
  CHECK(contains(confusion, ">100<"));
  REQUIRE(retrieve({"evaluate", scratch / "s.h5", "--confusion", scratch / "c.png"}).exit_code == 0);
  CHECK(read_file(scratch / "c.png").starts_with("\x89PNG"));
}

TEST_CASE("retrieve: mistakes are explained") {
  const ScratchFolder scratch;
  write_items(scratch / "s.h5");
  write_items(scratch / "bare.h5", false);
  write_items(scratch / "unlabeled.h5", true, false);
  const auto refusal = [&](const std::vector<std::string>& arguments) {
    const ProcessResult result = retrieve(arguments);
    CHECK(result.exit_code == 2);
    return result.err;
  };
  CHECK(contains(refusal({"evaluate", scratch / "bare.h5"}), "has no descriptors"));
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--descriptor", "plaec"}),
                 "did you mean `place`?; it has place, flat, wide"));
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--descriptor", "place+"}), "no descriptor ``"));
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--descriptor", "error"}), "no descriptor `error`"));
  CHECK(contains(refusal({"evaluate", scratch / "unlabeled.h5"}), "--classes FILE.cla"));
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--distance", "chi3"}), "did you mean `chi2`?"));
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--confusion", "c.gif"}), ".png or .svg"));
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--picture", "c.png"}), ".svg"));
  CHECK(contains(refusal({"evaluate", scratch / "absent.h5"}), "does not exist"));
  CHECK(contains(refusal({"query", scratch / "s.h5", "m99"}), "no item `m99`"));
  CHECK(contains(refusal({"query", scratch / "s.h5", "9"}), "unreadable"));
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--per-clas"}), "did you mean `--per-class`?"));
  CHECK(
      contains(refusal({"evaluate", scratch / "s.h5", "--classes", scratch / "absent.cla"}), "cannot open"));
  std::filesystem::create_directories(scratch / "folder.h5");
  CHECK(contains(refusal({"evaluate", scratch / "folder.h5"}), "it is not a regular file"));
  const std::string store = scratch / "s.h5";
  for (const char* option : {"--csv", "--matrix"})
    CHECK(contains(refusal({"evaluate", store, option, store}), "is the store itself"));
  CHECK(contains(refusal({"select", store, "--csv", store}), "is the store itself"));
  CHECK(contains(refusal({"query", store, "0", "--csv", store}), "is the store itself"));
  write_file(scratch / "none.cla", "PSB 1\n1 1\nfar 0 1\n777\n");
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--classes", scratch / "none.cla"}), "no model of"));
  write_file(scratch / "twice.cla", "PSB 1\n1 2\nfar 0 2\n16 m16\n");
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--classes", scratch / "twice.cla"}), "twice"));
  write_file(scratch / "lone.cla", "PSB 1\n1 1\nfar 0 1\n16\n");
  CHECK(contains(refusal({"evaluate", scratch / "s.h5", "--classes", scratch / "lone.cla"}),
                 "no class has two models"));
}

TEST_CASE("retrieve query --picture: a row per query, frames by class, surfaces where the meshes exist") {
  const ScratchFolder scratch;
  for (const char* folder : {"in/ball", "in/ring"}) std::filesystem::create_directories(scratch / folder);
  write_mesh(scratch / "in/ball/a.off", icosphere(1));
  write_mesh(scratch / "in/ball/b.off", moved(icosphere(2), 2, 1, 0, 0));
  write_mesh(scratch / "in/ring/c.off", torus(16, 8));
  write_file(scratch / "broken.off", "OFF\n3 1 0\n0 0\n");
  REQUIRE(meander_with({"run", scratch / "in", "-o", scratch / "s.h5", "-n", "128", "--label-from-folder",
                        "--describe", "pairs", "--progress", "none"})
              .exit_code == 0);
  const auto query = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"query", scratch / "s.h5"});
    return retrieve(more);
  };
  const ProcessResult result = query({"ball/a.off", "--mesh", scratch / "in/ring/c.off", "-k", "2", "--input",
                                      scratch / "in", "--picture", scratch / "hits.png", "--size", "64"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  constexpr std::uint32_t cell = 64, gap = 18, step = cell + gap, below = 37;
  const GrayImage picture = read_gray_png(scratch / "hits.png");
  REQUIRE(picture.width >= gap + 3 * step);
  const auto corner = [&](std::uint32_t column, std::uint32_t row) {
    const std::size_t x = gap + column * step, y = gap + row * (cell + below + gap);
    return picture.values[y * picture.width + x];
  };
  const auto luma = [](double r, double g, double b) {
    return Approx((0.2126 * r + 0.7152 * g + 0.0722 * b) / 255).margin(0.002);
  };
  const Approx of_query = luma(40, 40, 40), right = luma(0, 140, 90), wrong = luma(213, 94, 0),
               unknown = luma(190, 190, 190);
  CHECK(corner(0, 0) == of_query);
  CHECK(corner(1, 0) == right);
  CHECK(corner(2, 0) == wrong);
  CHECK(corner(0, 1) == of_query);
  CHECK(corner(1, 1) == unknown);  // a mesh has no class
  CHECK(corner(2, 1) == unknown);
  // Surfaces and points differ.
  for (const bool solid : {false, true}) {
    std::vector<std::string> words = {
        "ball/a.off", "-k", "2", "--size", "64", "--picture", scratch / (solid ? "solid.png" : "points.png")};
    if (solid) words.insert(words.end(), {"--input", scratch / "in"});
    REQUIRE(query(words).exit_code == 0);
  }
  CHECK(read_file(scratch / "points.png") != read_file(scratch / "solid.png"));
  // A mesh that cannot be read has a tile that says so.
  CHECK(query({"0", "--mesh", scratch / "broken.off", "--picture", scratch / "broken.png"}).exit_code == 3);
  CHECK(std::filesystem::exists(scratch / "broken.png"));
  // Refusals.
  const auto refusal = [&](std::vector<std::string> more) {
    const ProcessResult refused = query(std::move(more));
    CHECK(refused.exit_code == 2);
    return refused.err;
  };
  CHECK(contains(refusal({"0", "--picture", scratch / "hits.svg"}), "should end in .png"));
  CHECK(contains(refusal({"0", "--input", scratch / "in"}), "--picture"));
  CHECK(contains(refusal({"0", "1", "--picture", scratch / "x.png", "--memory", "49M", "--size", "1024"}),
                 "--memory"));
  std::vector<std::string> many(150, "0");
  many.insert(many.end(), {"-k", "3", "--picture", scratch / "many.png"});
  CHECK(contains(refusal(many), "are more than 400 pictures"));
}
