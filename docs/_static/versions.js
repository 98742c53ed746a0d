// Folders of the published versions, beside that of this one: docs/publish.py writes them.
const VERSIONS = [];
