// How the search of the site ranks pages: Sphinx's own scores, with pages in the user's way before the others.
// A record of a decision holds many words of a user, and answers few of his questions.
var Scorer = {
  score: ([docname, title, anchor, descr, score, filename, kind]) =>
    docname.startsWith("decisions/") ? score - 30 : docname.startsWith("api/") ? score - 3 : score,
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
