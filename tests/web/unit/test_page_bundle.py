"""The modules of the page as one script."""

from __future__ import annotations

import re

import pytest

from launcher.web import assets, page_bundle


def test_names_of_imports_and_exports_stay_what_they_are():
    module = page_bundle.module_of(
        'import { a, b as c } from "page/x.js";\n'
        'import * as Vue from "vue";\n'
        "export const d = a + c;\n"
        "export async function e() {\n"
        '  return import("page/y.js"), import(`page/${d}.js`), import("echarts");\n'
        "}\n"
        "export default { d };\n"
    )

    assert module.imports == ("page/x.js", "vue")
    assert module.exports == ("d", "e", "default")
    assert module.body == (
        "const { a, b: c } = $get('page/x.js');\n"
        "const Vue = $get('vue');\n"
        "const d = a + c;\n"
        "async function e() {\n"
        '  return $load("page/y.js"), $load(`page/${d}.js`), import("echarts");\n'
        "}\n"
        "const $default = { d };\n"
    )


@pytest.mark.parametrize(
    "text",
    [
        'export * from "page/x.js";\n',
        "export { a };\n",
        "export let a;\n",
        "export default class A {}\n",
        "import x;\n",
    ],
)
def test_another_form_of_import_or_export_is_refused(text: str):
    with pytest.raises(ValueError, match="another form"):
        page_bundle.module_of(text)


def test_the_script_has_all_modules_and_imports_nothing_else_of_ours():
    joined = assets.joined_files()
    script = joined[page_bundle.ENTRY][0].decode()
    makers = set(re.findall(r'^"page/([\w./-]+)"\(\) \{$', script, re.MULTILINE))

    assert makers | {page_bundle.ENTRY} == {name for name in joined if name.endswith(".js")}
    assert not re.search(r'(?:from|import\() ?["`]page/', script)
    assert re.findall(r'^import .* from "(.*)";$', script, re.MULTILINE) == ["vue"]


TEXTS = {
    f"page/{name}": path.read_text()
    for name, path in assets.own_files().items()
    if name.endswith(".js")
}


def test_what_a_module_imports_is_exported_there():
    # In the script it would be undefined, and nothing would say so.
    for name, text in TEXTS.items():
        for clause, source in page_bundle._IMPORT.findall(text):
            wanted = set(re.findall(r"[{,]\s*(\w+)", clause))
            if source in TEXTS:
                assert wanted <= set(page_bundle.module_of(TEXTS[source]).exports), name


def test_no_module_needs_itself():
    needs = {name: set(page_bundle.module_of(text).imports) for name, text in TEXTS.items()}
    while free := [name for name, needed in needs.items() if not needed & needs.keys()]:
        for name in free:
            del needs[name]
    assert not needs


def test_the_page_names_one_style_sheet_that_has_all():
    links = assets.STYLE_SHEET.findall(assets.index("key"))
    listed = assets.STYLE_SHEET.findall((assets.PAGE / "index.html").read_text())
    joined = assets.joined_files()[assets.JOINED_STYLES][0]

    assert links == [("page", assets.JOINED_STYLES)]
    assert len(listed) > 1
    places = {"lib": assets.libraries(), "page": assets.own_files()}
    assert joined == b"\n".join(places[place][name].read_bytes() for place, name in listed)
