// SPDX-License-Identifier: MIT OR Apache-2.0
if (picture.kind === "table") tablePage();
else environmentPage();
