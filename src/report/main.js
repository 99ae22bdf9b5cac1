if (picture.kind === "table") tablePage();
else environmentPage();
