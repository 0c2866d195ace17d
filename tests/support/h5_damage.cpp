// SPDX-License-Identifier: Apache-2.0
#include "support/h5_damage.h"

#include "ndg/core/error.h"
#include "support/support.h"

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <fstream>

namespace ndg::test {

Provenance example_provenance()
{
    Provenance provenance;
    provenance.tool = "test-body";
    provenance.config_json = R"({"rings": 5})";
    provenance.inputs = {{"base.obj", std::string(64, 'a'), ""}};
    provenance.licences = "tube: CC0";
    return provenance;
}

void run_python(const std::string& script)
{
    const TemporaryFolder folder;
    std::ofstream(folder.file("script.py")) << "import shutil\nimport h5py\nimport numpy as np\n" << script;
    const CommandResult result = run_command("/usr/bin/python3 " + folder.file("script.py"));
    INFO(result.output);
    REQUIRE(result.exit_code == 0);
}

void check_damages(const std::string& path, const std::vector<Damage>& damages,
                   const std::function<void(const std::string&)>& read)
{
    REQUIRE_NOTHROW(read(path));
    const auto copy = [&](std::size_t i) { return path + "." + std::to_string(i) + ".h5"; };
    std::string script =
        "def put(name, data):\n"
        "    del f[name]\n"
        "    f[name] = data\n";
    for (std::size_t i = 0; i < damages.size(); ++i) {
        script += "shutil.copy('" + path + "', '" + copy(i) + "')\n";
        script += "with h5py.File('" + copy(i) + "', 'r+') as f:\n    " + damages[i].python + "\n";
    }
    run_python(script);
    for (std::size_t i = 0; i < damages.size(); ++i) {
        INFO(damages[i].python);
        std::string message;
        try {
            read(copy(i));
        } catch (const InputError& error) {
            message = error.what();
        }
        INFO("message: " << message);
        CHECK(message.find(copy(i)) != std::string::npos);
        for (const std::string& word : damages[i].expected) CHECK(message.find(word) != std::string::npos);
    }
}

void check_by_h5py(const std::string& path, const std::string& format, const std::string& shapes, int version)
{
    run_python(fmt::format(R"(
import json
with h5py.File('{}', 'r') as f:
    attributes = dict(f.attrs)
    assert attributes['format'] == '{}', attributes
    assert attributes['format_version'] == {}, attributes
    assert attributes['units'] == 'm' and attributes['up_axis'] == 'y', attributes
    created_by = json.loads(attributes['created_by'])
    assert created_by['tool'] == 'test-body' and 'version' in created_by and 'commit' in created_by, created_by
    assert json.loads(attributes['config']) == {{'rings': 5}}, attributes
    inputs = json.loads(attributes['inputs'])
    assert inputs[0]['path'] == 'base.obj' and inputs[0]['sha256'] == 'a' * 64, inputs
    assert 'tube: CC0' in attributes['licences'], attributes
    found = {{}}
    f.visititems(lambda name, item: found.update({{'/' + name: item.shape}}) if isinstance(item, h5py.Dataset) else None)
    expected = {}
    assert found == expected, (found, expected)
    for name in found:
        if f[name].dtype.kind == 'f':
            assert np.isfinite(f[name][...]).all(), name
)",
                           path, format, version, shapes));
}

}  // namespace ndg::test
