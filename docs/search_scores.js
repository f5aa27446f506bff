// How the search ranks results: guides before the reference, both before studies and the changelog.
var Scorer = {
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
  score: ([page, , , , score]) => {
    if (page === "CHANGELOG") return score - 40;
    if (page.startsWith("experiments/") || page.startsWith("models/")) return score - 20;
    return page.startsWith("docs/api") || page === "docs/glossary" ? score - 5 : score;
  },
};
