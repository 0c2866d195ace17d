# SPDX-License-Identifier: Apache-2.0
# Installed like other software (cmake/Install.cmake, docs/install.md).

PREFIX ?= /usr/local

.PHONY: installable install package
installable:
	@pipelines/install-packages.sh --quiet
	@cmake -S . -B $(BUILD) $(CMAKE_FLAGS) > /dev/null
	@cmake --build $(BUILD) -j $(JOBS) --target installable

install: installable ## tools, libndg, configs, documentation to PREFIX=<folder> (/usr/local)
	@cmake --install $(BUILD) --prefix "$(abspath $(PREFIX))" > $(BUILD)/install.log || { cat $(BUILD)/install.log; exit 1; }
	@echo "installed to $(abspath $(PREFIX)): $$(wc -l < $(BUILD)/install_manifest.txt) files, named in $(BUILD)/install_manifest.txt"

package: installable ## the same as Debian packages, build/release/packages/*.deb
	@pipelines/install-packages.sh --quiet dpkg-dev
	@cd $(BUILD) && cpack > package.log 2>&1 || { cat package.log; exit 1; }
	@ls -1 $(BUILD)/packages/*.deb
