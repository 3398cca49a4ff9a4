# SPDX-License-Identifier: Apache-2.0
# segserve_add_pages(TARGET) bundles the pages of client/page into sources of TARGET, and defines SEGSERVE_WITH_PAGE for it. The
# packages of npm are those of package-lock.json.
include(${CMAKE_CURRENT_LIST_DIR}/../npm_packages.cmake)

function(segserve_add_pages target)
  set(folder ${CMAKE_CURRENT_SOURCE_DIR}/page)
  segserve_npm_packages(modules page ${folder})
  if(NOT modules)
    message(STATUS "segctl and segserve are built without their pages")
    return()
  endif()

  segserve_bundle_page(${target} ${modules} view_page_bundle src kViewPage app.js colors.js dendrogram.js depth_shading.js dom.js frame_budget.js ground_truth.js keys.js line_shapes.js loading.js main.js merge_tree.js page.html page_data.js painting.js pane.js panel.js ply_file.js point_material.js point_order.js region_graph.js selection.js side.js statistics.js style.css upload.js viewer.js)
  segserve_bundle_page(${target} ${modules} bench_page_bundle bench kBenchPage chart.js figures.js histogram.js latency.js main.js outcomes.js overview.js page.html setup.js split.js split_section.js style.css table.js throughput.js)
  target_compile_definitions(${target} PRIVATE SEGSERVE_WITH_PAGE)
endfunction()

# segserve_bundle_page(TARGET MODULES OUTPUT FOLDER SYMBOL SOURCE..) bundles the page in client/page/FOLDER into OUTPUT.html, and
# into a source of TARGET with its text as SYMBOL.
function(segserve_bundle_page target modules output folder symbol)
  set(page ${CMAKE_CURRENT_SOURCE_DIR}/page)
  set(bundle ${CMAKE_CURRENT_BINARY_DIR}/${output})
  list(TRANSFORM ARGN PREPEND ${page}/${folder}/ OUTPUT_VARIABLE sources)
  add_custom_command(
    OUTPUT ${bundle}.cpp
    BYPRODUCTS ${bundle}.html
    COMMAND ${NODE} ${page}/build.js ${modules} ${page}/${folder} ${bundle}.html ${bundle}.cpp ${symbol}
    DEPENDS ${page}/build.js ${page}/src/dom.js ${sources} ${modules}/../complete
    COMMENT "Bundling the page in client/page/${folder}"
    VERBATIM)
  target_sources(${target} PRIVATE ${bundle}.cpp)
  set_source_files_properties(${bundle}.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION TRUE SKIP_PRECOMPILE_HEADERS TRUE)
endfunction()
