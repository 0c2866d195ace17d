// SPDX-License-Identifier: Apache-2.0
// Our files against an independent implementation: h5py reads what we write, we read what h5py writes.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/h5.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <iostream>

using namespace ndg;
using namespace ndg::test;

namespace {

/// A Python with h5py, or "" with a printed line.
std::string python_with_h5py()
{
    for (const std::string python : {"/usr/bin/python3", "python3"}) {
        if (run_command(python + " -c 'import h5py, numpy'").exit_code == 0) return python;
    }
    std::cout << "Skipped: no python3 with h5py (Debian: python3-h5py)" << std::endl;
    return "";
}

void run_script(const std::string& python, const TemporaryFolder& folder, const std::string& script)
{
    write_file(folder.file("script.py"), script);
    const CommandResult result = run_command("cd " + folder.path() + " && " + python + " script.py");
    INFO(result.output);
    CHECK(result.exit_code == 0);
}

}  // namespace

TEST_CASE("h5py reads our layout, types and attributes")
{
    const std::string python = python_with_h5py();
    if (python.empty()) return;
    const TemporaryFolder folder;
    {
        Provenance provenance;
        provenance.tool = "make-template";
        provenance.licences = "CC0: someone";
        H5Writer writer(folder.file("x.h5"), "test-file", 3, provenance);
        RowMatrix matrix(2, 3);
        matrix << 1, 2, 3, 4, 5, 6;
        RowMatrixI indices(2, 2);
        indices << 10, 11, 12, -13;
        writer.write("/mesh/vertices", matrix, "points");
        writer.write("/mesh/exact", matrix, "points", Storage::float64);
        writer.write("/mesh/edges", indices, "edges");
        writer.write("/names", std::vector<std::string>{"left_foot", "", "Fuß"}, "names");
        writer.write("/times", std::vector<double>{0.1}, "times");
        writer.create("/samples", {2, 3, 4}, "samples");
        for (std::size_t i = 0; i < 2; ++i) {
            std::vector<float> slice;
            for (std::size_t k = 0; k < 12; ++k) slice.push_back(static_cast<float>(100 * i + k));
            writer.write_slice("/samples", i, slice.data());
        }
        writer.attribute("thickness", 0.25);
        writer.commit();
    }
    run_script(python, folder, R"(
import h5py, json, numpy as np
f = h5py.File('x.h5', 'r')
v = f['/mesh/vertices']
assert v.dtype == np.dtype('<f4') and v.shape == (2, 3)
assert (v[...] == [[1, 2, 3], [4, 5, 6]]).all() and v.attrs['description'] == 'points'
assert v.shuffle and v.fletcher32 and v.compression == 'gzip' and v.compression_opts == 4 and v.chunks == (2, 3)
assert f['/mesh/exact'].dtype == np.dtype('<f8')
e = f['/mesh/edges']
assert e.dtype == np.dtype('<i4') and (e[...] == [[10, 11], [12, -13]]).all()
assert list(f['/names'].asstr()[...]) == ['left_foot', '', 'Fuß']
assert f['/times'][0] == 0.1
s = f['/samples']
assert s.shape == (2, 3, 4) and s.dtype == np.dtype('<f4')
assert s[1, 2, 3] == 111 and s[1, 0, 1] == 101 and s[0, 1, 0] == 4
a = f.attrs
assert a['format'] == 'test-file' and a['format_version'] == 3 and a['format_version'].dtype == np.int32
assert a['units'] == 'm' and a['up_axis'] == 'y' and a['licences'] == 'CC0: someone' and a['thickness'] == 0.25
assert json.loads(a['created_by'])['tool'] == 'make-template'
assert json.loads(a['config']) == {} and json.loads(a['inputs']) == []
)");
}

TEST_CASE("we read what h5py writes, and refuse its bad values")
{
    const std::string python = python_with_h5py();
    if (python.empty()) return;
    const TemporaryFolder folder;
    run_script(python, folder, R"(
import h5py, numpy as np
f = h5py.File('x.h5', 'w')
f.attrs.update(format='test-file', format_version=1, units='m', up_axis='y')
f.attrs['fixed'] = np.bytes_('fixed text')
f['wide'] = np.array([[1.5, 2.5]])
f['big_endian'] = np.array([[1.5, 2.5]], dtype='>f4')
f['bytes'] = np.array([b'ab', b'c'])
f['long'] = np.array([1, 2**40])
f['unsigned'] = np.array([2**64 - 1], dtype='u8')
f['nan'] = np.array([[1, 2], [np.nan, 4]])
f['scalar'] = 3.0
f.create_dataset('promise', (10**9, 3), chunks=(1000, 3), dtype='f4')
g = h5py.File('y.h5', 'w')
g.attrs.update(format='test-file', format_version=1, units='cm', up_axis='y')
h = h5py.File('z.h5', 'w')
h['x'] = [1]
)");
    const H5Reader reader(folder.file("x.h5"), "test-file", 1);
    CHECK(reader.attribute("fixed") == "fixed text");
    CHECK(reader.read_matrix("/wide")(0, 1) == 2.5);
    CHECK(reader.read_matrix("/big_endian")(0, 1) == 2.5);
    CHECK(reader.read_strings("/bytes") == std::vector<std::string>{"ab", "c"});
    CHECK_THROWS_WITH(reader.read_ints("/long", 2, 0, 5),
                      Catch::Contains("/long at 1 is 1099511627776, expected 0 to 5"));
    CHECK_THROWS_AS(reader.read_ints("/unsigned", 1, -1, 5), InputError);
    CHECK_THROWS_WITH(reader.read_matrix("/nan"), Catch::Contains("/nan is not finite at (1, 0): nan"));
    CHECK_THROWS_WITH(reader.read_slice("/nan", 1), Catch::Contains("slice 1 of dataset /nan is not finite at 0"));
    CHECK_THROWS_WITH(reader.read_matrix("/scalar"), Catch::Contains("/scalar is a scalar, expected N x N"));
    CHECK_THROWS_WITH(reader.read_slice("/scalar", 0), Catch::Contains("is a scalar"));
    CHECK_THROWS_WITH(reader.read_matrix("/promise"),
                      Catch::Contains("/promise promises 12000000000 bytes but holds 0"));
    CHECK_THROWS_WITH(check_h5(folder.file("x.h5")), Catch::Contains("not finite in row 1"));
    CHECK_THROWS_WITH(H5Reader(folder.file("y.h5"), "test-file", 1),
                      Catch::Contains("units is \"cm\", expected \"m\""));
    CHECK_THROWS_WITH(H5Reader(folder.file("z.h5"), "test-file", 1), Catch::Contains("attribute format is missing"));
}
