// SPDX-License-Identifier: Apache-2.0
// Draws the diagrams of a page; without Mermaid they stay text.
'use strict';
if (window.mermaid) window.mermaid.initialize({startOnLoad: true, theme: 'neutral', securityLevel: 'strict', htmlLabels: true});
