// Stores with columns of the user's choice: what is stored, read back, verified, merged and refused.
#include <cmath>
#include <limits>

#include "io/store/pointnet_export.h"
#include "io/store/run_array.h"
#include "io/store/run_plan.h"
#include "io/store/schema.h"
#include "io/store/store_file.h"
#include "store_support.h"
#include "support/catch.h"
#include "support/sanitized.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

StoreColumns with_attributes() {
  StoreColumns columns{.asked = ColumnSet(&Samples::texcoord)};
  columns.attributes = {{"flow", 3}, {"label", 1, AttributeKind::classes}, {"pair", 2}, {"quality", 1},
                        {"wide", 4}, {"words", 3, AttributeKind::classes}};
  return columns;
}

// The same with classes that have names.
StoreColumns with_names() {
  StoreColumns columns = with_attributes();
  columns.attributes.insert(columns.attributes.begin() + 2, {"object", 1, AttributeKind::classes});
  return columns;
}

StoreHeader header_with(const StoreColumns& columns, std::uint64_t rows, std::uint32_t samples,
                        Compression compression = Compression::standard) {
  StoreHeader header = make_header(rows, samples, compression);
  header.columns = columns;
  return header;
}

// NaN equals NaN.
bool same_floats(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), 4 * a.size()) == 0);
}

bool same_chosen(const Row& a, const Row& b) {
  const Samples &s = a.samples, &t = b.samples;
  if (a.report.lacks != b.report.lacks || !same_floats(s.texcoord, t.texcoord)) return false;
  if (s.attributes.size() != t.attributes.size() || s.classes != t.classes) return false;
  for (std::size_t i = 0; i < s.attributes.size(); ++i)
    if (!same_floats(s.attributes[i], t.attributes[i])) return false;
  return true;
}

// All rows of a dataset as its chunks hold them.
std::vector<std::byte> values_of(const std::filesystem::path& store, const std::string& path) {
  const store::Hdf5Lock lock;
  const store::StoreFileReader reader(store);
  const auto& datasets = reader.layout().datasets;
  for (std::size_t d = 0; d < datasets.size(); ++d) {
    if (datasets[d].spec.path != path) continue;
    std::vector<std::byte> values(reader.layout().rows * datasets[d].row_bytes);
    reader.read_rows(d, 0, reader.layout().rows, values);
    return values;
  }
  return {};
}

}  // namespace

TEST_CASE("columns: attributes and texture coordinates are read back, whatever the chunk shape") {
  for (const std::uint32_t samples : {3u, 500u, 2000u, 200000u})
    for (const Compression compression : {Compression::standard, Compression::none}) {
      const std::uint64_t rows = samples > 10000 ? 3 : 40;
      const StoreHeader header = header_with(with_attributes(), rows, samples, compression);
      const ScratchFolder folder;
      write_store(folder / "s.h5", header, 5);
      const StoreReader reader(folder / "s.h5");
      CHECK(reader.columns() == with_attributes());
      CHECK(reader.format_version() == store_format_version);
      for (std::uint64_t row = 0; row < rows; ++row) {
        const Row made = make_row(header, row), read = reader.read_row(row);
        CHECK(same(made, read));
        // Rows that are not ok read back without samples.
        if (made.report.status == Status::ok) CHECK(same_chosen(made, read));
        const Row decoded = decode_row(header, make_encoded(header, row));
        if (made.report.status == Status::ok) CHECK(same_chosen(made, decoded));
      }
      CHECK(verify_store(folder / "s.h5").problems == std::vector<std::string>{});
      CHECK(*reader.header().columns == with_attributes());
    }
}

TEST_CASE("columns: a store without optional columns is unchanged") {
  const ScratchFolder folder;
  write_store(folder / "s.h5", make_header(20, 100));
  const StoreReader reader(folder / "s.h5");
  CHECK(reader.format_version() == store_format_version);
  CHECK(reader.columns() == StoreColumns{});
  const std::filesystem::path copy = folder / "copy.h5";  // the reader has the other one open
  std::filesystem::copy_file(folder / "s.h5", copy);
  const store::Hdf5Lock lock;
  const store::Hdf5File file(H5Fopen(copy.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), "open");
  CHECK(H5Aexists(file.get(), "columns") == 0);
  for (const char* path : {"attributes", "texcoord", "items/lacks"})
    CHECK(H5Lexists(file.get(), path, H5P_DEFAULT) == 0);
}

TEST_CASE("columns: kept columns equal those of the full store, and rows are smaller") {
  const ScratchFolder folder;
  const StoreHeader whole = header_with(with_attributes(), 60, 300);
  write_store(folder / "whole.h5", whole);
  StoreColumns fewer = with_attributes();
  fewer.left_out = ColumnSet(&Samples::normals, &Samples::corners, &Samples::density);
  const StoreHeader part = header_with(fewer, 60, 300);
  write_store(folder / "part.h5", part);
  CHECK(verify_store(folder / "part.h5").problems == std::vector<std::string>{});
  const StoreReader reader(folder / "part.h5");
  CHECK(reader.columns() == fewer);
  for (const std::string& path : store::column_list(StoredColumns(fewer)))
    CHECK(values_of(folder / "part.h5", "/" + path) == values_of(folder / "whole.h5", "/" + path));
  for (std::uint64_t row = 0; row < 60; ++row) {
    const Row read = reader.read_row(row);
    CHECK(read.samples.normals.empty());
    CHECK(read.samples.density.empty());
    if (read.report.status == Status::ok) CHECK(read.samples.face.size() == 300);
  }
  write_store(folder / "points.h5", header_with(points_alone_columns(), 60, 300));
  CHECK(verify_store(folder / "points.h5").problems == std::vector<std::string>{});
  CHECK(std::filesystem::file_size(folder / "points.h5") < std::filesystem::file_size(folder / "part.h5"));
  CHECK(std::filesystem::file_size(folder / "part.h5") < std::filesystem::file_size(folder / "whole.h5"));
}

TEST_CASE("columns: a missing column is named with the option that stores it") {
  const ScratchFolder folder;
  write_store(folder / "s.h5", header_with(points_alone_columns(), 3, 10));
  const StoreReader reader(folder / "s.h5");
  CHECK_THROWS_WITH(
      reader.require(&Samples::normals, "--pointnet"),
      ContainsSubstring("no `normals`, which --pointnet needs") && ContainsSubstring("--store ...,normals"));
  CHECK_THROWS_WITH(reader.require(&Samples::uv, "x"), ContainsSubstring("its models are meshes"));
  CHECK_THROWS_WITH(reader.require(&Samples::tensor_direction, "x"), ContainsSubstring("not anisotropic"));
  CHECK_THROWS_WITH(export_pointnet(reader, folder / "out"), ContainsSubstring("no `normals`"));
  write_store(folder / "all.h5", make_header(3, 10));
  CHECK_NOTHROW(StoreReader(folder / "all.h5").require(&Samples::normals, "x"));
}

TEST_CASE("columns: any row order and any number of restarts give the same bytes") {
  for (const std::uint32_t samples : {20u, 1500u}) {
    const StoreHeader header = header_with(with_attributes(), 30, samples);
    const std::string expected = store_bytes(header);
    const ScratchFolder folder;
    for (std::uint64_t begin = 0; begin < 30; begin += 7) {
      RunDirectory run(folder / "s.h5", header);
      for (std::uint64_t row = begin; row < std::min<std::uint64_t>(begin + 7, 30); ++row)
        run.end_item(make_encoded(header, row));
      if (run.done_count() == 30) run.finish();
    }
    CHECK(read_file(folder / "s.h5") == expected);
    write_store(folder / "other.h5", header, 99);
    CHECK(read_file(folder / "other.h5") == expected);
  }
}

TEST_CASE("columns: a run is continued only with the same columns") {
  const ScratchFolder folder;
  const StoreHeader header = header_with(with_attributes(), 30, 20);
  {
    RunDirectory run(folder / "s.h5", header);
    run.end_item(make_encoded(header, 0));
  }
  CHECK(refusal(folder / "s.h5", header).second == 2);
  StoreHeader plain = header;
  plain.columns = StoreColumns{};
  CHECK_THAT(refusal(folder / "s.h5", plain).first,
             ContainsSubstring("the columns were") && ContainsSubstring("attributes/flow"));
  StoreColumns fewer = with_attributes();
  fewer.left_out = ColumnSet(&Samples::face);
  plain.columns = fewer;
  CHECK_THAT(refusal(folder / "s.h5", plain).first, ContainsSubstring("the columns were"));
}

TEST_CASE("columns: verify compares the stored values with what items say they lack") {
  const ScratchFolder folder;
  const StoreHeader header = header_with(with_attributes(), 4, 30);
  const auto problems_with = [&](auto change) {
    RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 4; ++row) {
      Row made = make_row(header, row);
      if (made.report.status == Status::ok) change(made);
      run.end_item(encode_row(header, row, made));
    }
    run.finish();
    std::string all;
    for (const std::string& problem : verify_store(folder / "s.h5").problems) all += problem + "\n";
    return all;
  };
  CHECK(problems_with([](Row&) {}).empty());
  CHECK_THAT(
      problems_with([](Row& row) {
        row.report.lacks |= 8;
        for (float& value : row.samples.attributes[3]) value = 1;
      }),
      ContainsSubstring("has no NaN in /attributes/quality, but /items/lacks says that it lacks some"));
  CHECK_THAT(problems_with([](Row& row) {
               row.report.lacks &= ~64u;
               row.samples.texcoord[3] = std::numeric_limits<float>::quiet_NaN();
             }),
             ContainsSubstring("has NaN in /texcoord, but /items/lacks says that it lacks none"));
  CHECK_THAT(
      problems_with([](Row& row) { row.samples.attributes[0][5] = std::numeric_limits<float>::infinity(); }),
      ContainsSubstring("/attributes/flow that is infinite"));
  CHECK_THAT(problems_with([](Row& row) { row.report.lacks |= 128; }),
             ContainsSubstring("lacks columns that the store does not have"));
  CHECK_THAT(problems_with([](Row& row) {
               row.report.lacks |= 2;
               for (std::int32_t& value : row.samples.classes[1]) value = 5;
             }),
             ContainsSubstring("has no -1 in /attributes/label, but /items/lacks says that it lacks some"));
  CHECK_THAT(problems_with([](Row& row) {
               row.report.lacks |= 2;
               row.report.missing |= 2;
               row.samples.classes[1][0] = no_sample_class;
               row.samples.classes[1][1] = 5;
             }),
             ContainsSubstring("has classes in /attributes/label, but /items/missing says that it has none"));
  CHECK_THAT(problems_with([](Row& row) {
               row.report.lacks &= ~1u;
               row.report.missing |= 1;
             }),
             ContainsSubstring("is missing columns that it does not lack"));
  // A class of a model may be -1.
  CHECK(problems_with([](Row& row) {
          row.report.lacks &= ~2u;
          row.report.missing &= ~2u;
          row.samples.classes[1][0] = no_sample_class;
        }).empty());
}

TEST_CASE("columns: classes are int32 with fill -1, and part of the plan of a run") {
  const ScratchFolder folder;
  const StoreHeader header = header_with(with_attributes(), 12, 30);
  write_store(folder / "s.h5", header);
  {
    const store::Hdf5Lock lock;
    const store::Hdf5File file(H5Fopen((folder / "s.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), "open");
    const store::Hdf5Dataset dataset(H5Dopen2(file.get(), "/attributes/label", H5P_DEFAULT), "open");
    const store::Hdf5Type type(H5Dget_type(dataset.get()), "type");
    CHECK(H5Tequal(type.get(), H5T_STD_I32LE) > 0);
    const store::Hdf5Properties creation(H5Dget_create_plist(dataset.get()), "properties");
    std::int32_t fill = 0;
    REQUIRE(H5Pget_fill_value(creation.get(), type.get(), &fill) >= 0);
    CHECK(fill == -1);
  }
  { RunDirectory run(folder / "t.h5", header); }
  CHECK(*read_run_plan(folder / "t.h5")->header.columns == with_attributes());
  StoreColumns floats = with_attributes();
  floats.attributes[1].kind = AttributeKind::plain;
  StoreHeader other = header;
  other.columns = floats;
  CHECK_THAT(refusal(folder / "t.h5", other).first, ContainsSubstring("the columns were"));
  floats.attributes[1].kind = AttributeKind::linear;  // stored as plain
  CHECK(StoredColumns(floats)->attributes[1].kind == AttributeKind::plain);
}

TEST_CASE("columns: class names are read back, whatever the chunk shape") {
  for (const std::uint32_t samples : {3u, 2000u, 200000u})
    for (const Compression compression : {Compression::standard, Compression::none}) {
      if (sanitized && samples > 10000 && compression == Compression::none)
        continue;  // release builds try all
      const std::uint64_t rows = samples > 10000 ? 6 : 50;
      StoreHeader header = header_with(with_names(), rows, samples, compression);
      if (samples > 10000) header.descriptors.clear();
      const ScratchFolder folder;
      write_store(folder / "s.h5", header, 5);
      CHECK(verify_store(folder / "s.h5").problems == std::vector<std::string>{});
      const StoreReader reader(folder / "s.h5");
      CHECK(reader.columns() == with_names());
      RunDirectory copy(folder / "copy.h5", header);
      for (std::uint64_t row = rows; row-- > 0;) {  // any order
        const Row made = make_row(header, row);
        CHECK(same(made, reader.read_row(row)));
        CHECK((reader.names(row) == made.names));
        CHECK((decode_row(header, make_encoded(header, row)).names == made.names));
        CopiedRow copied = reader.copy_row(row);
        CHECK((copied.row.names == made.names));
        if (samples > 10000 && made.report.status == Status::ok) {  // as rows of very many samples are
          copied.row = {reader.report(row), {}, {}, reader.names(row)};
          copied.blocks = [&, row](std::uint64_t begin, std::uint64_t end) {
            return reader.read_samples(row, begin, end);
          };
        }
        copy.end_item(encode_row(header, row, std::move(copied)));
      }
      copy.finish();
      CHECK((read_file(folder / "copy.h5") == read_file(folder / "s.h5")));
    }
}

TEST_CASE("columns: a merged store has the class names of one process, in packs too") {
  const ScratchFolder folder;
  const StoreHeader header = header_with(with_names(), 9000, 2);
  write_store(folder / "one.h5", header);
  RunArray array;
  array.rows = 9000;
  array.arguments = {"plan"};
  array.shards = {{0, 3000, 1}, {3000, 3001, 1}, {3001, 9000, 1}};
  for (const bool packed : {false, true}) {
    const std::filesystem::path store = folder / (packed ? "packed.h5" : "whole.h5");
    create_run_array(store, array, {header}, [](std::size_t, const std::filesystem::path&) {});
    for (std::size_t s = 0; s < array.shards.size(); ++s) {
      const StoreHeader part = read_shard_plan(store, s).header;
      RunDirectory run(shard_store(store, s), part);
      for (std::uint64_t row = 0; row < part.ids.size(); ++row) {
        Row made = make_row(header, array.shards[s].begin + row);
        run.end_item(encode_row(part, row, made));
      }
      run.finish();
    }
    merge_run_array(store, array, packed ? 4096 : 0);
    CHECK(verify_store(store).problems == std::vector<std::string>{});
    if (!packed) CHECK((read_file(store) == read_file(folder / "one.h5")));
    {
      const StoreReader reader(store);
      for (const std::uint64_t row : {0ull, 1ull, 2999ull, 3000ull, 3001ull, 4095ull, 4096ull, 8999ull})
        CHECK((reader.names(row) == make_row(header, row).names));
    }
    if (!packed) continue;
    // As any program reads an index: all names as one list. The packs must not be open otherwise.
    const store::Hdf5Lock lock;
    const store::StoreFileReader index(store);
    std::string all(index.names_bytes(), '\0'), expected;
    index.read_names(0, std::as_writable_bytes(std::span(all)));
    for (std::uint64_t row = 0; row < 9000; ++row) expected += make_row(header, row).names;
    CHECK((all == expected));
  }
}

TEST_CASE("columns: verify checks class names") {
  const ScratchFolder folder;
  const StoreHeader header = header_with(with_names(), 4, 30);
  const auto problems_with = [&](const std::string& names) {
    RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 4; ++row) {
      Row made = make_row(header, row);
      made.names = names;
      run.end_item(encode_row(header, row, made));
    }
    run.finish();
    std::string all;
    for (const std::string& problem : verify_store(folder / "s.h5").problems) all += problem + "\n";
    return all;
  };
  CHECK(problems_with("").empty());
  CHECK(problems_with("{}").empty());
  CHECK(problems_with(R"({"object":["a","\u00e9",""]})").empty());
  CHECK_THAT(problems_with("["), ContainsSubstring("names that are no JSON"));
  CHECK_THAT(problems_with("[]"), ContainsSubstring("no JSON object"));
  CHECK_THAT(problems_with(R"({"object":[1]})"), ContainsSubstring("no lists of texts"));
  CHECK_THAT(problems_with(R"({"object":"a"})"), ContainsSubstring("no lists of texts"));
  Row long_names = make_row(header, 0);
  for (std::uint64_t row = 0; long_names.report.status != Status::ok; ++row)
    long_names = make_row(header, row);
  long_names.names.assign(most_name_bytes + 1, 'x');
  CHECK_THROWS_AS(encode_row(header, 0, long_names), ItemError);
}

TEST_CASE("columns: attribute names are parsed, and invalid column choices are refused") {
  for (const char* good : {"quality", "_TEMPERATURE", "a b", "\xC3\xA9", "x.y", "..a", "0"})
    CHECK(attribute_name_problem(good).empty());
  for (const std::string& bad :
       {std::string(), std::string("."), std::string(".."), std::string("a/b"), std::string("a,b"),
        std::string("a:b"), std::string("a\nb"), std::string("\xFF"), std::string("\x7F"),
        std::string(201, 'a'), std::string("a\0b", 3)})
    CHECK_FALSE(attribute_name_problem(bad).empty());
  const auto made = [](std::vector<AttributeColumn> attributes) {
    StoreColumns columns;
    columns.attributes = std::move(attributes);
    return StoredColumns(columns);
  };
  CHECK_NOTHROW(made({{"a", 1}, {"b", 4}}));
  CHECK_THROWS_AS(made({{"b", 1}, {"a", 1}}), ItemError);
  CHECK_THROWS_AS(made({{"a", 1}, {"a", 2}}), ItemError);
  CHECK_THROWS_AS(made({{"a", 5}}), ItemError);
  CHECK_THROWS_AS(made({{"a", 0}}), ItemError);
  CHECK_THROWS_AS(made({{"a/b", 1}}), ItemError);
  std::vector<AttributeColumn> many;
  for (int i = 0; i < 33; ++i) many.push_back({std::string(1, static_cast<char>('A' + i)), 1});
  CHECK_THROWS_AS(made(many), ItemError);
  many.pop_back();
  CHECK_NOTHROW(made(many));
}

TEST_CASE("columns: the sizes of plain columns come from one table") {
  CHECK(&StoredColumns().table() == &StoredColumns(StoreColumns{}).table());
  const StoredColumns chosen(with_attributes());
  const StoredColumns copy = chosen;
  CHECK(&copy.table() == &chosen.table());
  CHECK(copy == StoredColumns(with_attributes()));
  CHECK_FALSE(copy == StoredColumns());
}
